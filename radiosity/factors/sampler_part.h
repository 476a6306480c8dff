// sampler_part.h - the sampler's own data, for the files that make it, draw in it and sum it.
#ifndef RADIOSITY_SAMPLER_PART_H
#define RADIOSITY_SAMPLER_PART_H

#include "engine/core/lanes.h"
#include "radiosity/factors/sampler.h"
#include "radiosity/mesh/lines.h"

enum { GROUP_SIDE = 4, GROUP_BLOCKS = GROUP_SIDE * GROUP_SIDE };

// 8 rows of 8 directions. Where they are flat - over a plane, as those of the disc -, x is that of the column and y that of
// the row, and less memory is asked for.
typedef struct SampleBlock {
    Lane z[SAMPLER_BLOCK], rows, columns, x[SAMPLER_BLOCK], y[SAMPLER_BLOCK];
} SampleBlock;

// The depths seen in a block: 1 / distance (places without a sample: infinite) and the face there (Mesh.faces; -1: nothing).
typedef struct ItemBlock {
    Lane near[SAMPLER_BLOCK];
    LaneInt face[SAMPLER_BLOCK];
} ItemBlock;

// For each of eight things, the box about its directions, as middle and half its size, and the least 1 / distance seen
// in it. The boxes are larger than their directions by what the rounding of a form can amount to.
typedef struct SampleBoxes {
    Lane x, y, z, half_x, half_y, half_z;
    Lane far;
} SampleBoxes;

// dot((x, y, z), w) as floats, and the sizes of the three.
typedef struct Form {
    float x, y, z, unused;
    float abs_x, abs_y, abs_z, unused_abs;
} Form;

typedef struct GridForm {
    float x, y, z;
} GridForm;

// The square that a direction meets, or
enum { NOTHING = -1, BACK = -2, MANY = -3 };

// A view's eye, its axes as columns, so that x * v.x + y * v.y + z * v.z is v in those axes, and how the samples'
// axes are turned from these: `stay` of each number, and `cross` of the other of x and y.
typedef struct ViewFrame {
    Four x, y, z, stay, cross;
    Vec3 eye;
} ViewFrame;

static inline Four view_frame_of(const ViewFrame *frame, Vec3 v) {
    return frame->x * v.x + frame->y * v.y + frame->z * v.z;
}

// In the samples' axes.
static inline Four view_frame_turned(const ViewFrame *frame, Four v) {
    return v * frame->stay + __builtin_shufflevector(v, v, 1, 0, 3, 2) * frame->cross;
}

// Where on a face a direction meets it: column dot(column, w) * distance, row alike.
typedef struct FaceGrid {
    GridForm column, row;
    int first_square, nx, ny;
    int one;  // what all of the face is, MANY: look where
} FaceGrid;

struct Sampler {
    const Mesh *mesh;
    FaceLines outlines;
    double cosine, sine;         // of the turn of the samples' axes from the view's
    SampleBlock *blocks;         // [block_count]
    ItemBlock *items, *nothing;  // as blocks; before anything is drawn
    unsigned char *masks;        // [.. * SAMPLER_BLOCK] of each row of 8: bit i, there is a sample in lane i
    float *weights;              // [.. * 64] 0 where there is no sample
    SampleBoxes *block_boxes, *group_boxes;  // [group_count * 2], [(group_count + 15) / 16 * 2]
    int group_count, block_count;
    int *first_block;      // [group_count] of its blocks that have samples: these alone are kept
    unsigned short *used;  // [group_count] bit i: box i has samples
    FormFactorSamples samples;
    bool flat;   // all blocks are
    bool equal;  // all weights are the same: samples are counted
    // The view at hand.
    ViewFrame frame;
    int *grid_stamp;        // [face_count]
    int *lone;              // [face_count] of faces of one element: a square that has it, else MANY
    int *view_index;        // [face_count] of the faces in view
    FaceGrid *grids;        // [face_count]
    Form *edges;            // [most_edges] of the face under way: a direction is inside where none is below 0
    const Form **crossing;  // [most_edges] those that cross a block
    unsigned *crossed;      // [most_edges]
    int stamp;
};

// ---- ties (sampler_tie.c)

typedef struct SamplerView {
    const Sampler *sampler;
    const View *view;
} SamplerView;

// Rounding may change a face's 1 / distance and those drawn with it by this much, 1/m.
float sampler_tie_within(const Form *near);
// Is the first face seen where the two lie in one plane (1), the other (-1), or do they not (0)?
int sampler_tie_of_planes(const SamplerView *of, int face, int other);
// Is the first face seen along w (in the samples' axes), which both hold?
bool sampler_tie_along(const SamplerView *of, int face, int other, Vec3 w);

// The samples' axes.
static inline void sampler_axes(const Sampler *s, const View *view, Vec3 *x, Vec3 *y) {
    *x = vec3_add(vec3_scale(view->x, s->cosine), vec3_scale(view->y, s->sine));
    *y = vec3_sub(vec3_scale(view->y, s->cosine), vec3_scale(view->x, s->sine));
}

#endif
