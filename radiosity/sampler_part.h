// sampler_part.h - the sampler's own data, for the files that make it, draw in it and sum it.
#ifndef RADIOSITY_SAMPLER_PART_H
#define RADIOSITY_SAMPLER_PART_H

#include "radiosity/lane.h"
#include "radiosity/lines.h"
#include "radiosity/sampler.h"

enum { GROUP_SIDE = 4, GROUP_BLOCKS = GROUP_SIDE * GROUP_SIDE };

// 8 rows of 8 directions.
typedef struct SampleBlock {
    Lane x[SAMPLER_BLOCK], y[SAMPLER_BLOCK], z[SAMPLER_BLOCK];
} SampleBlock;

// What is seen in a block: 1 / distance (places without a sample: infinite) and the face there (Mesh.faces; -1: nothing).
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

// A direction w is inside a face when every edge's form is at least its threshold.
typedef struct DrawnEdge {
    Form form;
    float least;  // 0, or just above it: of two faces along a line one only holds it
} DrawnEdge;

typedef struct GridForm {
    float x, y, z;
} GridForm;

// What a direction meets: an element, or
enum { NOTHING = -1, BACK = -2, MANY = -3 };

// Where on a face a direction meets it: column dot(column, w) / dot(near, w), row alike.
typedef struct FaceGrid {
    GridForm column, row, near;
    int first_square, first_element, nx, ny;  // first_element -1: by the squares
    int one;                                  // what all of the face is, MANY: look it up
} FaceGrid;

struct Sampler {
    const Mesh *mesh;
    FaceLines outlines;
    double cosine, sine;         // of the turn of the samples' axes from the view's
    SampleBlock *blocks;         // [group_count * GROUP_BLOCKS]
    ItemBlock *items, *nothing;  // as blocks; before anything is drawn
    unsigned char *masks;        // [.. * SAMPLER_BLOCK] of each row of 8: bit i, there is a sample in lane i
    float *weights;              // [.. * 64] 0 where there is no sample
    SampleBoxes *block_boxes, *group_boxes;  // [group_count * 2], [(group_count + 15) / 16 * 2]
    int group_count;
    FormFactorSamples samples;
    bool equal;                // all weights are the same,
    double shares[LANES + 1];  // and so many of them weigh this
    // Of one view.
    int *grid_stamp;                          // [face_count]
    unsigned char *whole;                     // [face_count] each square has an element, one after the other
    int *view_index;                          // [face_count] of the faces in view
    FaceGrid *grids;                          // [face_count]
    DrawnEdge *edges;                         // [most_edges] of the face under way
    const DrawnEdge **all, **group, **block;  // [most_edges] those edges; those that cross a group, a block
    unsigned *crossed, *crossed_blocks;       // [most_edges]
    int stamp;
};

// ---- ties (sampler_tie.c)

typedef struct SamplerView {
    const Sampler *sampler;
    const View *view;
} SamplerView;

// What rounding may make of a face's 1 / distance and of those drawn with it, 1/m.
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
