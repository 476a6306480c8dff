// sampler.c - sets up blocks of directions: who is next to whom, the boxes about them, and the arrays of one view.
//
// The boxes stand in for bounds of faces: a great circle's extent on the disc or the cube needs care (extrema on arcs, on
// the rim), while the sign of a form over a box of directions is three multiplications, and serves any set of directions.
#include <math.h>

#include "radiosity/factors/sampler_part.h"

// Boxes are larger by this than their unit directions: a form's value at a direction or a box's corner is right to a few
// units in the last place of a float, as a share of the sum of its coefficients.
#define BOX_ROUNDING 1e-6f

typedef struct Extent {
    float low[3], high[3];
} Extent;

static const Extent EXTENT_EMPTY = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static void extend(Extent *e, const Extent *by) {
    for (int k = 0; k < 3; k++) {
        e->low[k] = fminf(e->low[k], by->low[k]);
        e->high[k] = fmaxf(e->high[k], by->high[k]);
    }
}

static void put_box(SampleBoxes *boxes, int lane, const Extent *e) {
    bool empty = e->low[0] > e->high[0];
    float middle[3] = {0}, half[3] = {0};
    for (int k = 0; k < 3 && !empty; k++) {
        middle[k] = 0.5f * (e->low[k] + e->high[k]);
        half[k] = fmaxf(e->high[k] - middle[k], middle[k] - e->low[k]) + BOX_ROUNDING;
    }
    boxes->x[lane] = middle[0];
    boxes->y[lane] = middle[1];
    boxes->z[lane] = middle[2];
    boxes->half_x[lane] = half[0];
    boxes->half_y[lane] = half[1];
    boxes->half_z[lane] = half[2];
    boxes->far[lane] = empty ? INFINITY : 0;
}

static int groups_along(int size) {
    int side = SAMPLER_BLOCK * GROUP_SIDE;
    return (size + side - 1) / side;
}

static int group_total(const SampleGrid *grids, int grid_count) {
    int total = 0;
    for (int g = 0; g < grid_count; g++)
        total += groups_along(grids[g].width) * groups_along(grids[g].height);
    return total;
}

// One sample: its place in the block, and at the end of the arrays in order.
static bool add_sample(Sampler *s, const SampleGrid *grid, int i, int j, int block, int row, int lane,
                       Extent *extent) {
    double w[3], weight;
    if (i >= grid->width || j >= grid->height || !grid->at(grid, i, j, w, &weight)) return false;
    double length = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    float unit[3] = {(float)(w[0] / length), (float)(w[1] / length), (float)(w[2] / length)};
    s->blocks[block].x[row][lane] = unit[0];
    s->blocks[block].y[row][lane] = unit[1];
    s->blocks[block].z[row][lane] = unit[2];
    s->blocks[block].columns[lane] = unit[0];
    s->blocks[block].rows[row] = unit[1];
    s->weights[(block * SAMPLER_BLOCK + row) * LANES + lane] = (float)weight;
    int at = s->samples.count++;
    s->samples.x[at] = (float)((w[0] * s->cosine - w[1] * s->sine) / length);
    s->samples.y[at] = (float)((w[0] * s->sine + w[1] * s->cosine) / length);
    s->samples.z[at] = unit[2];
    s->samples.weight[at] = (float)weight;
    Extent one;
    for (int k = 0; k < 3; k++) one.low[k] = one.high[k] = unit[k];
    extend(extent, &one);
    return true;
}

// A block whose first sample is (i, j) of the grid. False: it has none.
static bool list_block(Sampler *s, const SampleGrid *grid, int i, int j, int block, Extent *extent) {
    bool any = false;
    for (int row = 0; row < SAMPLER_BLOCK; row++) {
        unsigned mask = 0;
        for (int lane = 0; lane < LANES; lane++) {
            bool sample = add_sample(s, grid, i + lane, j + row, block, row, lane, extent);
            s->nothing[block].near[row][lane] = sample ? 0 : INFINITY;
            s->nothing[block].face[row][lane] = -1;
            mask |= (unsigned)sample << lane;
        }
        s->masks[block * SAMPLER_BLOCK + row] = (unsigned char)mask;
        any = any || mask != 0;
    }
    return any;
}

static void add_group(Sampler *s, const SampleGrid *grid, int i, int j, int group) {
    Extent whole = EXTENT_EMPTY;
    s->first_block[group] = s->block_count;
    for (int k = 0; k < GROUP_BLOCKS; k++) {
        Extent extent = EXTENT_EMPTY;
        bool any = list_block(s, grid, i + k % GROUP_SIDE * SAMPLER_BLOCK, j + k / GROUP_SIDE * SAMPLER_BLOCK,
                              s->block_count, &extent);
        s->used[group] |= (unsigned short)(any << k);
        s->block_count += any;
        put_box(&s->block_boxes[group * 2 + k / LANES], k % LANES, &extent);
        extend(&whole, &extent);
    }
    put_box(&s->group_boxes[group / LANES], group % LANES, &whole);
}

static bool is_flat(const Sampler *s) {
    for (int row = 0; row < s->block_count * SAMPLER_BLOCK; row++) {
        for (unsigned mask = s->masks[row]; mask; mask &= mask - 1) {
            const SampleBlock *b = &s->blocks[row / SAMPLER_BLOCK];
            int lane = __builtin_ctz(mask);
            if (b->x[row % SAMPLER_BLOCK][lane] != b->columns[lane]) return false;
            if (b->y[row % SAMPLER_BLOCK][lane] != b->rows[row % SAMPLER_BLOCK]) return false;
        }
    }
    return true;
}

static void scale_weights(Sampler *s) {
    double sum = 0;
    float least = INFINITY, most = 0;
    for (int i = 0; i < s->samples.count; i++) {
        sum += s->samples.weight[i];
        least = fminf(least, s->samples.weight[i]);
        most = fmaxf(most, s->samples.weight[i]);
    }
    s->equal = least == most;
    for (int i = 0; i < s->samples.count; i++) s->samples.weight[i] = (float)(s->samples.weight[i] / sum);
    for (int i = 0; i < s->block_count * SAMPLER_BLOCK * LANES; i++)
        s->weights[i] = (float)(s->weights[i] / sum);
}

static int lone_square(const Mesh *mesh, const Face *face) {
    int at = face->first_square;
    if (face->element_count != 1) return MANY;
    while (mesh->squares[at] == -1) at++;
    return at;
}

static void take_view_memory(Sampler *s, Arena *arena) {
    s->grid_stamp = ARENA_ARRAY(arena, int, s->mesh->face_count + 1);
    s->view_index = ARENA_ARRAY(arena, int, s->mesh->face_count + 1);
    s->grids = ARENA_ARRAY(arena, FaceGrid, s->mesh->face_count + 1);
    s->lone = ARENA_ARRAY(arena, int, s->mesh->face_count + 1);
    for (int f = 0; f < s->mesh->face_count; f++) s->lone[f] = lone_square(s->mesh, &s->mesh->faces[f]);
    s->edges = ARENA_ARRAY(arena, Form, s->outlines.most_edges + 1);
    s->crossing = ARENA_ARRAY(arena, const Form *, s->outlines.most_edges + 1);
    s->crossed = ARENA_ARRAY(arena, unsigned, s->outlines.most_edges + 1);
}

Sampler *sampler_new(const Mesh *mesh, const FaceLines *lines, const SampleGrid *grids, int grid_count,
                     double turn, Arena *arena) {
    Sampler *s = ARENA_ARRAY(arena, Sampler, 1);
    s->mesh = mesh;
    s->cosine = cos(turn);
    s->sine = sin(turn);
    s->outlines = lines ? *lines : lines_of_mesh(mesh, arena);
    s->group_count = group_total(grids, grid_count);
    int blocks = s->group_count * GROUP_BLOCKS + 1, places = blocks * SAMPLER_BLOCK * LANES;  // one to try
    s->blocks = ARENA_ARRAY(arena, SampleBlock, blocks);
    s->items = ARENA_ARRAY(arena, ItemBlock, blocks);
    s->nothing = ARENA_ARRAY(arena, ItemBlock, blocks);
    s->masks = ARENA_ARRAY(arena, unsigned char, blocks *SAMPLER_BLOCK);
    s->weights = ARENA_ARRAY(arena, float, places);
    s->first_block = ARENA_ARRAY(arena, int, s->group_count);
    s->used = ARENA_ARRAY(arena, unsigned short, s->group_count);
    s->block_boxes = ARENA_ARRAY(arena, SampleBoxes, s->group_count * 2);
    int pairs = (s->group_count + 2 * LANES - 1) / (2 * LANES);
    s->group_boxes = ARENA_ARRAY(arena, SampleBoxes, pairs * 2);
    s->samples.x = ARENA_ARRAY(arena, float, places);
    s->samples.y = ARENA_ARRAY(arena, float, places);
    s->samples.z = ARENA_ARRAY(arena, float, places);
    s->samples.weight = ARENA_ARRAY(arena, float, places);
    for (int i = 0; i < pairs * 2 * LANES; i++) put_box(&s->group_boxes[i / LANES], i % LANES, &EXTENT_EMPTY);
    int group = 0, side = SAMPLER_BLOCK * GROUP_SIDE;
    for (int g = 0; g < grid_count; g++)
        for (int j = 0; j < grids[g].height; j += side)
            for (int i = 0; i < grids[g].width; i += side) add_group(s, &grids[g], i, j, group++);
    scale_weights(s);
    s->flat = is_flat(s);
    take_view_memory(s, arena);
    return s;
}

const FormFactorSamples *sampler_samples(const Sampler *self) { return &self->samples; }
