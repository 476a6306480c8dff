// sampler_row.c - what was drawn, as items or as shares of elements: of a direction w that sees a face, column and row in the
// face's grid are linear in w over dot(n, w) / d, so that an element is found by one division (design.md: "find the element
// under a sample from where it hits its polygon").
#include <string.h>

#include "radiosity/factors/row.h"
#include "radiosity/factors/sampler_part.h"

void sampler_items(const Sampler *self, int32_t *item) {
    for (int row = 0; row < self->block_count * SAMPLER_BLOCK; row++) {
        const int32_t *face = (const int32_t *)&self->items[row / SAMPLER_BLOCK].face[row % SAMPLER_BLOCK];
        for (unsigned mask = self->masks[row]; mask; mask &= mask - 1) {
            int seen = face[__builtin_ctz(mask)];
            *item++ = seen < 0 ? -1 : self->view_index[seen];
        }
    }
}

static GridForm grid_form(const Sampler *s, Vec3 v) {
    Four turned = view_frame_turned(&s->frame, view_frame_of(&s->frame, v));
    return (GridForm){(float)turned[0], (float)turned[1], (float)turned[2]};
}

static const FaceGrid NO_FACE = {.one = NOTHING};

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
    *grid = (FaceGrid){.column = grid_form(s, column),
                       .row = grid_form(s, row),
                       .first_square = f->first_square,
                       .nx = f->nx,
                       .ny = f->ny,
                       .one = seen->d > 0 ? BACK : s->lone[face]};
    return grid;
}

static inline Lane form_at(GridForm f, const SampleBlock *b, int row) {
    return lane_multiply_add(lane_of(f.x), b->x[row],
                             lane_multiply_add(lane_of(f.y), b->y[row], lane_of(f.z) * b->z[row]));
}

// Eight numbers as whole ones in 0 .. count - 1; 0 in place of one that is no number.
static inline LaneInt whole(Lane a, Lane most) {
    return __builtin_convertvector(lane_least(lane_most(a, (Lane){0}), most), LaneInt);
}

// Puts, where `here` says that a block's directions meet the face, the squares in which they do.
static inline void meet_face(const FaceGrid *grid, const SampleBlock *b, const Lane distance[SAMPLER_BLOCK],
                             const LaneInt here[SAMPLER_BLOCK], LaneInt square[SAMPLER_BLOCK]) {
    Lane last_column = lane_of((float)grid->nx - 0.5f), last_line = lane_of((float)grid->ny - 0.5f);
    LANE_UNROLL
    for (int row = 0; row < SAMPLER_BLOCK; row++) {
        LaneInt column = whole(form_at(grid->column, b, row) * distance[row], last_column);
        LaneInt line = whole(form_at(grid->row, b, row) * distance[row], last_line);
        square[row] =
            lane_choose_int(here[row], line * grid->nx + (column + grid->first_square), square[row]);
    }
}

static inline void put_square(int32_t value, const LaneInt here[SAMPLER_BLOCK],
                              LaneInt square[SAMPLER_BLOCK]) {
    LANE_UNROLL
    for (int row = 0; row < SAMPLER_BLOCK; row++)
        square[row] = lane_choose_int(here[row], lane_int_of(value), square[row]);
}

// The squares, of Mesh.squares, or what there is instead, where a block's directions in `mask` end.
static inline void find_squares(Sampler *s, const View *view, int block, uint64_t mask,
                                LaneInt square[SAMPLER_BLOCK]) {
    const LaneInt *faces = s->items[block].face;
    Lane distance[SAMPLER_BLOCK];
    LANE_UNROLL
    for (int row = 0; row < SAMPLER_BLOCK; row++) distance[row] = 1 / s->items[block].near[row];
    for (uint64_t left = mask, seen; left; left &= ~seen) {
        int at = __builtin_ctzll(left), face = ((const int32_t *)faces)[at];
        LaneInt here[SAMPLER_BLOCK];
        seen = 0;
        LANE_UNROLL
        for (int row = 0; row < SAMPLER_BLOCK; row++) {
            here[row] = faces[row] == face;
            seen |= (uint64_t)lane_mask(here[row]) << (row * LANES);
        }
        const FaceGrid *grid = face < 0 ? &NO_FACE : grid_of(s, view, face);
        if (grid->one == MANY)
            meet_face(grid, &s->blocks[block], distance, here, square);
        else
            put_square(grid->one, here, square);
    }
}

// Where the polygon is not, by a rounding or beside a slanted edge: the nearest square that has an element.
static int element_beside(const Sampler *s, const View *view, int block, int at) {
    const SampleBlock *b = &s->blocks[block];
    int row = at / LANES, lane = at % LANES, face = s->items[block].face[row][lane];
    double x = (double)b->x[row][lane], y = (double)b->y[row][lane], z = (double)b->z[row][lane];
    double distance = 1 / (double)s->items[block].near[row][lane];
    Vec3 side, up;
    sampler_axes(s, view, &side, &up);
    Vec3 w = vec3_add(vec3_scale(side, x), vec3_add(vec3_scale(up, y), vec3_scale(view->z, z)));
    return mesh_element_at(s->mesh, face, vec3_add(view->eye, vec3_scale(w, distance)));
}

// The places `run` of a block.
static double share_of(const Sampler *s, int block, uint64_t run) {
    if (s->equal) return __builtin_popcountll(run);
    double share = 0;
    for (; run; run &= run - 1)
        share += (double)s->weights[block * SAMPLER_BLOCK * LANES + __builtin_ctzll(run)];
    return share;
}

static void add_beside(const Sampler *s, const View *view, int block, uint64_t run, RowSum *sum) {
    for (; run; run &= run - 1) {
        int element = element_beside(s, view, block, __builtin_ctzll(run));
        row_add(sum, element, share_of(s, block, run & -run));
    }
}

static void add_nothing(const Sampler *s, const View *view, int block, uint64_t run, RowSum *sum) {
    const SampleBlock *b = &s->blocks[block];
    Vec3 side, up;
    sampler_axes(s, view, &side, &up);
    sum->escaped += share_of(s, block, run);
    for (; run; run &= run - 1) {
        int at = __builtin_ctzll(run), row = at / LANES, lane = at % LANES;
        double height = (double)b->x[row][lane] * side.z + (double)b->y[row][lane] * up.z +
                        (double)b->z[row][lane] * view->z.z;
        if (height > 0) sum->sky += share_of(s, block, run & -run);
    }
}

// A block's directions, neighbours in one square at once.
static void sum_block(Sampler *s, const View *view, int block, uint64_t mask, RowSum *sum) {
    LaneInt square[SAMPLER_BLOCK] = {0};
    find_squares(s, view, block, mask, square);
    uint64_t ends = 0;
    LANE_UNROLL
    for (int row = 0; row < SAMPLER_BLOCK; row++) {
        LaneInt next = __builtin_shufflevector(square[row], square[row], 1, 2, 3, 4, 5, 6, 7, 7);
        ends |= (uint64_t)((~lane_mask(square[row] == next) & 0xff) | 1 << (LANES - 1)) << (row * LANES);
    }
    for (uint64_t left = ~(uint64_t)0; ends; ends &= ends - 1) {
        int end = __builtin_ctzll(ends), at = ((const int32_t *)square)[end];
        uint64_t run = left & (ends ^ (ends - 1)) & mask;
        left = ~(ends ^ (ends - 1));
        if (run == 0) continue;
        double share = share_of(s, block, run);
        int element = at >= 0 ? s->mesh->squares[at] : -1;
        if (element >= 0)
            row_add(sum, element, share);
        else if (at >= 0)
            add_beside(s, view, block, run, sum);
        else if (at == BACK)
            sum->back += share;
        else
            add_nothing(s, view, block, run, sum);
    }
}

// Bytes of a table asked for ahead at most.
enum { MOST_FETCHED = 4096 };

static void fetch(const void *from, size_t bytes) {
    for (size_t i = 0; i < bytes && i < MOST_FETCHED; i += 64) __builtin_prefetch((const char *)from + i);
}

// Fetches the data for most of the row while its beginning is on its way: the faces in the corners of the blocks' halves.
static void fetch_faces(Sampler *s, const View *view, const RowSum *sum) {
    for (int at = 0; at < s->block_count * SAMPLER_BLOCK; at += SAMPLER_BLOCK / 2) {
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
    for (int block = 0; block < s->block_count; block++) {
        uint64_t mask;
        memcpy(&mask, s->masks + block * SAMPLER_BLOCK, sizeof mask);
        if (mask) sum_block(s, view, block, mask, sum);
    }
}
