// sampler_row.c - what was drawn, as items or as shares of elements: of a direction w that sees a face, column and row in the
// face's grid are linear in w over dot(n, w) / d, so that an element is found by one division (design.md: "find the element
// under a sample from where it hits its polygon").
#include <string.h>

#include "radiosity/row.h"
#include "radiosity/sampler_part.h"

void sampler_items(const Sampler *self, int32_t *item) {
    for (int row = 0; row < self->group_count * GROUP_BLOCKS * SAMPLER_BLOCK; row++) {
        const int32_t *face = (const int32_t *)&self->items[row / SAMPLER_BLOCK].face[row % SAMPLER_BLOCK];
        for (unsigned mask = self->masks[row]; mask; mask &= mask - 1) {
            int seen = face[__builtin_ctz(mask)];
            *item++ = seen < 0 ? -1 : self->view_index[seen];
        }
    }
}

static GridForm grid_form(const Sampler *s, const View *view, Vec3 v) {
    Vec3 x, y;
    sampler_axes(s, view, &x, &y);
    return (GridForm){(float)vec3_dot(x, v), (float)vec3_dot(y, v), (float)vec3_dot(view->z, v)};
}

static const FaceGrid *grid_of(Sampler *s, const View *view, int face) {
    FaceGrid *grid = &s->grids[face];
    if (s->grid_stamp[face] == s->stamp) return grid;
    s->grid_stamp[face] = s->stamp;
    const Face *f = &s->mesh->faces[face];
    const ViewFace *seen = &view->faces[s->view_index[face]];
    // The plane's point along w is w / dot(n / d, w) from the eye.
    Vec3 near = vec3_scale(f->plane.n, 1 / seen->d), from = vec3_sub(view->eye, f->origin);
    Vec3 column = vec3_add(f->gx, vec3_scale(near, vec3_dot(f->gx, from)));
    Vec3 row = vec3_add(f->gy, vec3_scale(near, vec3_dot(f->gy, from)));
    *grid = (FaceGrid){.column = grid_form(s, view, column),
                       .row = grid_form(s, view, row),
                       .near = grid_form(s, view, near),
                       .first_square = f->first_square,
                       .first_element = s->whole[face] ? f->first_element : -1,
                       .nx = f->nx,
                       .ny = f->ny,
                       .one = seen->d > 0             ? BACK
                              : f->element_count == 1 ? f->first_element
                                                      : MANY};
    return grid;
}

static inline Lane form_at(GridForm f, const SampleBlock *b, int row) {
    return lane_multiply_add(lane_of(f.x), b->x[row],
                             lane_multiply_add(lane_of(f.y), b->y[row], lane_of(f.z) * b->z[row]));
}

// Of eight numbers, whole ones in 0 .. count - 1.
static inline LaneInt whole(Lane a, int count) {
    a = lane_choose(a > 0, a, (Lane){0});  // not a number: 0, too
    return __builtin_convertvector(lane_least(a, lane_of((float)count - 0.5f)), LaneInt);
}

// Where the polygon is not, by a rounding or beside a slanted edge: the nearest square that has an element.
static int element_beside(const Sampler *s, const View *view, int face, const SampleBlock *b, int row,
                          int lane) {
    const GridForm *near = &s->grids[face].near;
    double x = (double)b->x[row][lane], y = (double)b->y[row][lane], z = (double)b->z[row][lane];
    double distance = 1 / ((double)near->x * x + (double)near->y * y + (double)near->z * z);
    Vec3 side, up;
    sampler_axes(s, view, &side, &up);
    Vec3 w = vec3_add(vec3_scale(side, x), vec3_add(vec3_scale(up, y), vec3_scale(view->z, z)));
    return mesh_element_at(s->mesh, face, vec3_add(view->eye, vec3_scale(w, distance)));
}

// The elements, or what there is instead, where a row of directions meets a face; only lanes of `mask` mean anything.
static inline LaneInt elements_on(Sampler *s, const View *view, int face, int block, int row, unsigned mask) {
    if (face < 0) return lane_int_of(NOTHING);
    const FaceGrid *grid = grid_of(s, view, face);
    if (grid->one != MANY) return lane_int_of(grid->one);
    const SampleBlock *b = &s->blocks[block];
    Lane distance = 1 / form_at(grid->near, b, row);
    LaneInt column = whole(form_at(grid->column, b, row) * distance, grid->nx);
    LaneInt line = whole(form_at(grid->row, b, row) * distance, grid->ny);
    LaneInt square = line * grid->nx + column;
    if (grid->first_element >= 0) return grid->first_element + square;
    LaneInt element = lane_look_up(s->mesh->squares, grid->first_square + square);
    for (unsigned lost = lane_mask(element) & mask; lost; lost &= lost - 1) {
        int lane = __builtin_ctz(lost);
        element[lane] = element_beside(s, view, face, b, row, lane);
    }
    return element;
}

static void add_share(RowSum *sum, int element, double share) {
    if (element >= 0)
        row_add(sum, element, share);
    else if (element == BACK)
        sum->back += share;
    else
        sum->escaped += share;
}

// Adds a row of eight, neighbours in one element at once.
static inline void add_row(const Sampler *s, int at, LaneInt element, unsigned mask, RowSum *sum) {
    LaneInt next = __builtin_shufflevector(element, element, 1, 2, 3, 4, 5, 6, 7, 7);
    unsigned ends = (~lane_mask(element == next) & 0xff) | 0x80;
    for (int from = 0; ends; ends &= ends - 1) {
        int end = __builtin_ctz(ends) + 1;
        unsigned run = mask & (0xffu >> (LANES - end)) & (0xffu << from);
        from = end;
        if (run == 0) continue;
        double share = s->equal ? s->shares[__builtin_popcount(run)] : 0;
        if (!s->equal)
            for (; run; run &= run - 1) share += (double)s->weights[at * LANES + __builtin_ctz(run)];
        add_share(sum, element[end - 1], share);
    }
}

// Bytes of a table asked for ahead at most.
enum { MOST_FETCHED = 4096 };

static void fetch(const void *from, size_t bytes) {
    for (size_t i = 0; i < bytes && i < MOST_FETCHED; i += 64) __builtin_prefetch((const char *)from + i);
}

// What most of the row will ask for, while the first of it is on its way: the faces in the corners of the blocks' halves.
static void fetch_faces(Sampler *s, const View *view, const RowSum *sum) {
    for (int at = 0; at < s->group_count * GROUP_BLOCKS * SAMPLER_BLOCK; at += SAMPLER_BLOCK / 2) {
        if (s->masks[at] == 0) continue;
        int face = s->items[at / SAMPLER_BLOCK].face[at % SAMPLER_BLOCK][__builtin_ctz(s->masks[at])];
        if (face < 0 || s->grid_stamp[face] == s->stamp) continue;
        const FaceGrid *grid = grid_of(s, view, face);
        if (grid->one == BACK) continue;
        size_t elements = (size_t)s->mesh->faces[face].element_count;
        fetch(sum->share + s->mesh->faces[face].first_element, elements * sizeof *sum->share);
        fetch(s->mesh->squares + grid->first_square, (size_t)grid->nx * (size_t)grid->ny * sizeof(int));
    }
}

void sampler_row(Sampler *s, const View *view, RowSum *sum) {
    fetch_faces(s, view, sum);
    for (int at = 0; at < s->group_count * GROUP_BLOCKS * SAMPLER_BLOCK; at++) {
        unsigned mask = s->masks[at], left = mask;
        if (mask == 0) continue;
        int block = at / SAMPLER_BLOCK, row = at % SAMPLER_BLOCK;
        LaneInt faces = s->items[block].face[row], element = lane_int_of(NOTHING);
        while (left) {
            int face = faces[__builtin_ctz(left)];
            LaneInt here = faces == lane_int_of(face);
            unsigned seen = lane_mask(here) & mask;
            element = lane_choose_int(here, elements_on(s, view, face, block, row, seen), element);
            left &= ~seen;
        }
        add_row(s, at, element, mask, sum);
    }
}
