// row.c - turns sums of shares into rows. The element that a sample meets is found from the point where its direction meets the
// face's plane: with the face's grid in the view's axes this takes one division a sample, for any number of elements.
#include "radiosity/factors/row.h"

#include <math.h>
#include <stdint.h>

#include "engine/core/error.h"

// The grid of a face in the view's axes: a direction w meets column floor(dot(x, w) / dot(n, w)), and row likewise with y.
typedef struct RowFace {
    float n[3], x[3], y[3];
    float columns, rows;   // one less than the grid has
    int nx, first_square;  // first_square -1: the face's back is seen
    int face;
    unsigned stamp;  // RowSum.stamp of the row that these numbers are for
} RowFace;

void row_start(RowSum *sum, const Mesh *mesh, Arena *arena) {
    *sum = (RowSum){.mesh = mesh};
    sum->share = ARENA_ARRAY(arena, double, mesh->element_count);
    sum->touched = ARENA_ARRAY(arena, int, mesh->element_count + 1);
    sum->row.element = ARENA_ARRAY(arena, int, mesh->element_count);
    sum->row.factor = ARENA_ARRAY(arena, float, mesh->element_count);
    sum->word_count = mesh->element_count / 64 + 1;
    sum->marked = ARENA_ARRAY(arena, uint64_t, sum->word_count);
    sum->faces = ARENA_ARRAY(arena, RowFace, mesh->face_count);
}

void row_start_sky(RowSum *sum, const FormFactorOptions *options, Arena *arena) {
    sum->day = options->day;
    sum->panes = options->panes;
    if (!options->sky_parts) return;
    sum->collector = sky_collector_new(arena);
    sum->sky_part = ARENA_ARRAY(arena, SkyPart, SKY_PARTS_MOST);
}

void row_escape(RowSum *sum, const View *view, double share, Vec3 direction) {
    double through = share;
    if (sum->panes && sum->panes->count > 0)
        through *= panes_transmit_from_afar(sum->panes, view->eye, direction);
    sum->escaped += share;
    if (!(direction.z > 0)) {
        sum->ground_light += through;
        return;
    }
    sum->sky += share;
    if (sum->collector && through > 0) sky_collector_add(sum->collector, through, direction);
    sum->sky_light += sum->day ? through * daylight_relative(sum->day, direction) : through;
}

// Sorts `touched` in increasing order and removes repetitions, with a bit for each element.
static void sort_touched(RowSum *sum) {
    int low = sum->word_count, high = -1, count = 0;
    for (int i = 0; i < sum->touched_count; i++) {
        int word = sum->touched[i] / 64;
        sum->marked[word] |= (uint64_t)1 << (sum->touched[i] % 64);
        if (word < low) low = word;
        if (word > high) high = word;
    }
    for (int word = low; word <= high; word++) {
        for (uint64_t bits = sum->marked[word]; bits; bits &= bits - 1)
            sum->touched[count++] = word * 64 + __builtin_ctzll(bits);
        sum->marked[word] = 0;
    }
    // An element whose first shares were 0 was in the list several times.
    sum->touched_count = count;
}

const Row *row_finish(RowSum *sum) {
    Row *row = &sum->row;
    sort_touched(sum);
    double total = sum->back + sum->escaped;
    for (int i = 0; i < sum->touched_count; i++) total += sum->share[sum->touched[i]];
    double scale = total > 0 ? 1 / total : 0;
    row->count = 0;
    for (int i = 0; i < sum->touched_count; i++) {
        int element = sum->touched[i];
        float factor = (float)(sum->share[element] * scale);
        sum->share[element] = 0;
        if (!(factor > 0)) continue;
        row->element[row->count] = element;
        row->factor[row->count++] = factor;
    }
    row->back = sum->back * scale;
    row->escaped = sum->escaped * scale;
    // near_faces_mend may have reduced `escaped`, but not `sky`.
    row->sky = fmin(sum->sky * scale, row->escaped);
    row->sky_light = sum->sky_light * scale;
    row->ground_light = sum->ground_light * scale;
    row->sky_part = sum->sky_part;
    if (sum->collector) row->sky_part_count = sky_collector_take(sum->collector, sum->sky_part);
    sum->touched_count = 0;
    sum->back = sum->escaped = sum->sky = sum->sky_light = sum->ground_light = 0;
    return row;
}

// ---- samples

static void to_view(const View *view, Vec3 v, float out[3]) {
    out[0] = (float)vec3_dot(view->x, v);
    out[1] = (float)vec3_dot(view->y, v);
    out[2] = (float)vec3_dot(view->z, v);
}

// The plane's point along w is w d / dot(n, w); its grid coordinate is dot(g, w) d / dot(n, w) + c, where c is the eye's coordinate.
static void lay_face(const RowSum *sum, const View *view, int item, RowFace *out) {
    const ViewFace *seen = &view->faces[item];
    const Face *face = &sum->mesh->faces[seen->face];
    Vec3 n = face->plane.n, from = vec3_sub(view->eye, face->origin);
    Vec3 x = vec3_add(vec3_scale(face->gx, seen->d), vec3_scale(n, vec3_dot(face->gx, from)));
    Vec3 y = vec3_add(vec3_scale(face->gy, seen->d), vec3_scale(n, vec3_dot(face->gy, from)));
    *out = (RowFace){.columns = (float)(face->nx - 1),
                     .rows = (float)(face->ny - 1),
                     .nx = face->nx,
                     .first_square = seen->d > 0 ? -1 : face->first_square,
                     .face = seen->face,
                     .stamp = sum->stamp};
    to_view(view, n, out->n);
    to_view(view, x, out->x);
    to_view(view, y, out->y);
}

static float dot3(const float a[3], float x, float y, float z) { return a[0] * x + a[1] * y + a[2] * z; }
// The index of the square at a grid coordinate; a coordinate outside the grid by rounding is clamped, and NAN gives 0.
static int square_along(float at, float last) { return (int)(at > 0 ? at < last ? at : last : 0); }

// The element of a sample whose square has none, because rounding puts the point outside the face.
static int stray(const RowSum *sum, const View *view, int item, Vec3 w) {
    const ViewFace *seen = &view->faces[item];
    Vec3 along =
        vec3_add(vec3_scale(view->x, w.x), vec3_add(vec3_scale(view->y, w.y), vec3_scale(view->z, w.z)));
    Vec3 n = sum->mesh->faces[seen->face].plane.n;
    double slope = vec3_dot(n, along), r = slope == 0 ? 0 : seen->d / slope;
    return mesh_element_at(sum->mesh, seen->face, vec3_add(view->eye, vec3_scale(along, r)));
}

Vec3 row_direction(const View *view, const FormFactorSamples *s, int i) {
    Vec3 side = vec3_scale(view->x, (double)s->x[i]), up = vec3_scale(view->y, (double)s->y[i]);
    return vec3_add(vec3_scale(view->z, (double)s->z[i]), vec3_add(side, up));
}

static void begin_faces(RowSum *sum) {
    if (++sum->stamp != 0) return;
    // The stamp wrapped around to 0: forget all old marks.
    for (int f = 0; f < sum->mesh->face_count; f++) sum->faces[f].stamp = 0;
    sum->stamp = 1;
}

// The element that a sample meets on the face of an item; -1: the face's back is seen.
static inline int element_met(RowSum *sum, const View *view, const FormFactorSamples *samples, int i,
                              int item) {
    RowFace *face = &sum->faces[item];
    if (face->stamp != sum->stamp) lay_face(sum, view, item, face);
    if (face->first_square < 0) return -1;
    float x = samples->x[i], y = samples->y[i], z = samples->z[i];
    float scale = 1 / dot3(face->n, x, y, z);
    int column = square_along(dot3(face->x, x, y, z) * scale, face->columns);
    int row = square_along(dot3(face->y, x, y, z) * scale, face->rows);
    int element = sum->mesh->squares[face->first_square + row * face->nx + column];
    return element < 0 ? stray(sum, view, item, (Vec3){(double)x, (double)y, (double)z}) : element;
}

void row_of_items(RowSum *sum, const View *view, const FormFactorSamples *samples, const int32_t *item) {
    begin_faces(sum);
    for (int i = 0; i < samples->count; i++) {
        if (item[i] < 0) {
            row_escape(sum, view, (double)samples->weight[i], row_direction(view, samples, i));
            continue;
        }
        int element = element_met(sum, view, samples, i, item[i]);
        if (element < 0)
            sum->back += (double)samples->weight[i];
        else
            row_add(sum, element, (double)samples->weight[i]);
    }
}

void row_elements(RowSum *sum, const View *view, const FormFactorSamples *samples, const int32_t *item,
                  int *out) {
    begin_faces(sum);
    for (int i = 0; i < samples->count; i++)
        out[i] = item[i] < 0 ? -1 : element_met(sum, view, samples, i, item[i]);
}
