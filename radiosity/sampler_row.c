// sampler_row.c - what was drawn, as items or as shares of elements: of a direction w that sees a face, column and row in the
// face's grid are linear in w over dot(n, w) / d, so that an element is found by one division (design.md: "find the element
// under a sample from where it hits its polygon").
#include <string.h>

#include "radiosity/row.h"
#include "radiosity/sampler_part.h"

void sampler_items(const Sampler *self, int32_t *item) {
    for (int row = 0; row < self->group_count * GROUP_BLOCKS * SAMPLER_BLOCK; row++) {
        const int32_t *face = (const int32_t *)&self->items[row / SAMPLER_BLOCK].face[row % SAMPLER_BLOCK];
        int first = self->runs[row] & 15, count = self->runs[row] >> 4;
        for (int lane = first; lane < first + count; lane++)
            *item++ = face[lane] < 0 ? -1 : self->view_index[face[lane]];
    }
}

static Form grid_form(const View *view, const ViewFace *face, Vec3 g, Vec3 origin) {
    double along = vec3_dot(g, vec3_sub(view->eye, origin)) / face->d;
    return (Form){(float)(vec3_dot(view->x, g) + along * face->n.x),
                  (float)(vec3_dot(view->y, g) + along * face->n.y),
                  (float)(vec3_dot(view->z, g) + along * face->n.z), 0};
}

static const FaceGrid *grid_of(Sampler *s, const View *view, int face) {
    FaceGrid *grid = &s->grids[face];
    if (s->grid_stamp[face] == s->stamp) return grid;
    s->grid_stamp[face] = s->stamp;
    const Face *f = &s->mesh->faces[face];
    const ViewFace *seen = &view->faces[s->view_index[face]];
    *grid = (FaceGrid){
        .column = grid_form(view, seen, f->gx, f->origin),
        .row = grid_form(view, seen, f->gy, f->origin),
        .near = {(float)(seen->n.x / seen->d), (float)(seen->n.y / seen->d), (float)(seen->n.z / seen->d), 0},
        .first_square = f->first_square,
        .nx = f->nx,
        .ny = f->ny,
        .one = f->element_count == 1 ? f->first_element : -1,
        .front = seen->d < 0};
    return grid;
}

static inline Lane form_at(Form f, const SampleBlock *b, int row) {
    return f.x * b->x[row] + f.y * b->y[row] + f.z * b->z[row];
}

// Of eight numbers, whole ones in 0 .. count - 1.
static inline LaneInt whole(Lane a, int count) {
    Lane most = lane_of((float)count - 0.5f);
    a = lane_choose(a > 0, a, (Lane){0});  // not a number: 0, too
    return __builtin_convertvector(lane_least(a, most), LaneInt);
}

// Where the polygon is not, by a rounding or beside a slanted edge: the nearest square that has an element.
static int element_beside(const Sampler *s, const View *view, const FaceGrid *grid, int face,
                          const float w[3]) {
    double near = (double)grid->near.x * w[0] + (double)grid->near.y * w[1] + (double)grid->near.z * w[2];
    Vec3 p = vec3_add(vec3_scale(view->x, w[0] / near),
                      vec3_add(vec3_scale(view->y, w[1] / near), vec3_scale(view->z, w[2] / near)));
    return mesh_element_at(s->mesh, face, vec3_add(view->eye, p));
}

// The elements at lanes first .. last of a row, all of which see one face.
static void elements_of_run(const Sampler *s, const View *view, const FaceGrid *grid, int face, int block,
                            int row, int first, int last, int32_t *element) {
    const SampleBlock *b = &s->blocks[block];
    Lane distance = 1 / form_at(grid->near, b, row);
    LaneInt column = whole(form_at(grid->column, b, row) * distance, grid->nx);
    LaneInt line = whole(form_at(grid->row, b, row) * distance, grid->ny);
    LaneInt square = grid->first_square + line * grid->nx + column;
    for (int lane = first; lane <= last; lane++) {
        element[lane] = s->mesh->squares[square[lane]];
        if (element[lane] >= 0) continue;
        float w[3] = {b->x[row][lane], b->y[row][lane], b->z[row][lane]};
        element[lane] = element_beside(s, view, grid, face, w);
    }
}

// Shares in the order of the samples; neighbours in one element are added at once.
typedef struct Adding {
    RowSum *sum;
    int element;
    double share;
} Adding;

static inline void add(Adding *a, int element, double share) {
    if (element != a->element && a->element >= 0) {
        row_add(a->sum, a->element, a->share);
        a->share = 0;
    }
    a->element = element;
    a->share += share;
}

static void add_run(Sampler *s, const View *view, int block, int row, int first, int last, int face,
                    Adding *a) {
    const float *weight = s->weights + ((size_t)block * SAMPLER_BLOCK + (size_t)row) * LANES;
    double whole_share = 0;
    const FaceGrid *grid = face < 0 ? NULL : grid_of(s, view, face);
    if (!grid || !grid->front || grid->one >= 0) {
        for (int lane = first; lane <= last; lane++) whole_share += weight[lane];
        if (!grid)
            a->sum->escaped += whole_share;
        else if (!grid->front)
            a->sum->back += whole_share;
        else
            add(a, grid->one, whole_share);
        return;
    }
    int32_t element[LANES];
    elements_of_run(s, view, grid, face, block, row, first, last, element);
    for (int lane = first; lane <= last; lane++) add(a, element[lane], weight[lane]);
}

void sampler_row(Sampler *s, const View *view, RowSum *sum) {
    Adding adding = {.sum = sum, .element = -1};
    for (int at = 0; at < s->group_count * GROUP_BLOCKS * SAMPLER_BLOCK; at++) {
        int block = at / SAMPLER_BLOCK, row = at % SAMPLER_BLOCK;
        int first = s->runs[at] & 15, end = first + (s->runs[at] >> 4);
        const int32_t *face = (const int32_t *)&s->items[block].face[row];
        while (first < end) {
            int last = first;
            while (last + 1 < end && face[last + 1] == face[first]) last++;
            add_run(s, view, block, row, first, last, face[first], &adding);
            first = last + 1;
        }
    }
    if (adding.element >= 0) row_add(sum, adding.element, adding.share);
}
