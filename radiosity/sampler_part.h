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
// in it.
typedef struct SampleBoxes {
    Lane x, y, z, half_x, half_y, half_z;
    Lane far;
} SampleBoxes;

// dot((x, y, z), w) as floats; `noise` is above the error of its value anywhere.
typedef struct Form {
    float x, y, z, noise;
} Form;

// A face ready to be drawn: a direction w is inside when every edge's form is at least its threshold, and sees it at
// 1 / distance = dot(near, w).
typedef struct DrawnEdge {
    Form form;
    float least;  // 0, or just above it: of two faces along a line one only holds it
} DrawnEdge;

// Where on a face a direction meets it: column dot(column, w) / dot(near, w), row alike.
typedef struct FaceGrid {
    Form column, row, near;
    int first_square, nx, ny, one;  // one: the only element, -1: there are more
    bool front;
} FaceGrid;

struct Sampler {
    const Mesh *mesh;
    FaceLines outlines;
    SampleBlock *blocks;         // [group_count * GROUP_BLOCKS]
    ItemBlock *items, *nothing;  // as blocks; before anything is drawn
    unsigned char *runs;         // [.. * SAMPLER_BLOCK] of each row of 8: first sample | count << 4
    float *weights;              // [.. * 64] 0 where there is no sample
    SampleBoxes *block_boxes, *group_boxes;  // [group_count * 2], [(group_count + 7) / 8]
    int group_count;
    FormFactorSamples samples;
    bool equal;  // all weights are the same
    // Of one view.
    Form *line_forms;  // [line_count] each made when first needed
    int *line_stamp, *grid_stamp;
    int *view_index;            // [face_count] of the faces in view
    FaceGrid *grids;            // [face_count]
    DrawnEdge *edges, *chosen;  // [most_edges] of the face under way; those that cross a block
    unsigned *crossed;          // [most_edges]
    int stamp;
};

#endif
