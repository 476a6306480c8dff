// analytic_row.c - the row of a point without samples: the visible part of each face is cut along the face's grid, and each piece
// is summed by Lambert's formula (analytic.c). Exact but for rounding, and slow: other methods are measured against this one.

#include <math.h>

#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "radiosity/factors/analytic.h"
#include "radiosity/factors/face_grid.h"
#include "radiosity/factors/occluder_sieve.h"
#include "radiosity/factors/row.h"

// A row whose sum misses 1 by no more than this is closed: the missing share is rounding, not sky.
#define ANALYTIC_CLOSED 1e-9
// Pieces of a smaller share than this are rounding where edges meet, through which no light may leak: a constant for the rounding
// of the row, plus a share for each metre of the eye's distance from the origin for the rounding of coordinates.
#define ANALYTIC_SLIT 1e-13
#define ANALYTIC_SLIT_FAR 4e-15

// The corners of the sky's triangles are this many times as far away as the farthest corner of a face; the middle of a triangle is
// at 0.58 of that distance, still behind all faces.
#define BEHIND 2

typedef struct Analytic {
    const Mesh *mesh;
    AnalyticOccluder *occluder;  // [face_count]
    Plane *edge;                 // [outline_count]
    OccluderSieve *sieve;        // of the occluders of the view
    // The face at hand.
    FaceGrid grid;
    RowSum *sum;
    double total, slit;
    bool back;
} Analytic;

static void *analytic_start(const Mesh *mesh, const FormFactorOptions *options, Arena *arena) {
    (void)options;
    Analytic *self = ARENA_ARRAY(arena, Analytic, 1);
    self->mesh = mesh;
    self->occluder = ARENA_ARRAY(arena, AnalyticOccluder, mesh->face_count);
    self->edge = ARENA_ARRAY(arena, Plane, mesh->outline_count);
    self->sieve = occluder_sieve_new(mesh->face_count, arena);
    return self;
}

static void extent(const Vec3 *polygon, int count, Vec3 g, double offset, int n, int *low, int *high) {
    double least = INFINITY, most = -INFINITY;
    for (int i = 0; i < count; i++) {
        double x = vec3_dot(g, polygon[i]) + offset;
        least = fmin(least, x), most = fmax(most, x);
    }
    *low = face_grid_clamp(least, n), *high = face_grid_clamp(most, n);
}

// The part of a polygon in strip i of the n strips of a grid; the first and the last strip reach beyond the grid. `out` has room
// for count + 2.
static int strip(const Vec3 *polygon, int count, Vec3 g, double offset, int i, int n, Vec3 *out) {
    Vec3 part[ANALYTIC_CORNERS + 2];
    const Vec3 *from = polygon;
    if (i > 0) count = polygon_clip(polygon, count, (Plane){g, i - offset}, 0, part), from = part;
    if (i < n - 1) return polygon_clip(from, count, (Plane){vec3_scale(g, -1), offset - (i + 1)}, 0, out);
    for (int k = 0; k < count; k++) out[k] = from[k];
    return count;
}

static void add_square(Analytic *self, const Vec3 *polygon, int count, int i, int j) {
    double share = analytic_point(polygon, count);
    if (share > 0) row_add(self->sum, face_grid_element(&self->grid, i, j), share);
}

static void add_row_piece(void *context, const Vec3 *polygon, int count) {
    Analytic *self = context;
    const FaceGrid *g = &self->grid;
    double share = analytic_point(polygon, count);
    if (!(share > self->slit)) return;
    self->total += share;
    if (self->back) self->sum->back += share;
    if (self->back) return;
    CORE_ASSERT(count + 4 <= ANALYTIC_CORNERS);
    Vec3 row[ANALYTIC_CORNERS], square[ANALYTIC_CORNERS];
    int i0, i1, j0, j1;
    extent(polygon, count, g->gy, g->y0, g->ny, &j0, &j1);
    for (int j = j0; j <= j1; j++) {
        int in_row = strip(polygon, count, g->gy, g->y0, j, g->ny, row);
        if (in_row < 3) continue;
        extent(row, in_row, g->gx, g->x0, g->nx, &i0, &i1);
        for (int i = i0; i <= i1; i++) {
            int in_square = strip(row, in_row, g->gx, g->x0, i, g->nx, square);
            if (in_square >= 3) add_square(self, square, in_square, i, j);
        }
    }
}

// The visible share of a quarter of the sky, from one horizontal axis of the building to the next: a triangle of these axes and the
// zenith, behind all faces.
static double sky_of(const Analytic *self, const View *view, int quarter, int occluders) {
    static const Vec3 AXES[5] = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {1, 0, 0}};
    static const Vec3 ZENITH = {0, 0, 1};
    double far = 1;
    for (int i = 0; i < view->vertex_count; i++) far = fmax(far, vec3_length(view->vertices[i]));
    Vec3 corner[3] = {ZENITH, AXES[quarter], AXES[quarter + 1]};
    for (int i = 0; i < 3; i++) {
        Vec3 v = vec3_scale(corner[i], BEHIND * far);
        corner[i] = vec3(vec3_dot(view->x, v), vec3_dot(view->y, v), vec3_dot(view->z, v));
    }
    return analytic_point_visible(corner, 3, self->occluder, occluders);
}

static void exact_row(void *context, const View *view, RowSum *sum, FormFactorWork *work) {
    Analytic *self = context;
    self->sum = sum;
    self->total = 0;
    self->slit = ANALYTIC_SLIT + ANALYTIC_SLIT_FAR * vec3_length(view->eye);
    int occluders = 0;
    Plane *edge = self->edge;
    occluder_sieve_clear(self->sieve);
    for (int i = 0; i < view->face_count; i++) {
        const ViewFace *f = &view->faces[i];
        AnalyticOccluder *o = &self->occluder[occluders];
        if (!analytic_occluder(view->vertices + f->first_vertex, f->vertex_count, form_factor_rank(f), edge,
                               o))
            continue;
        occluder_sieve_add(self->sieve, view->vertices + f->first_vertex, f->vertex_count);
        occluders++;
        edge += o->edge_count;
    }
    for (int i = 0; i < view->face_count; i++) {
        const ViewFace *f = &view->faces[i];
        self->grid = face_grid(self->mesh, view, f->face);
        self->back = f->d > 0;
        const Vec3 *polygon = view->vertices + f->first_vertex;
        int count;
        const int *which = occluder_sieve_ask(self->sieve, polygon, f->vertex_count, &count);
        work->tests += analytic_visible_among(polygon, f->vertex_count, form_factor_rank(f), self->occluder,
                                              which, count, add_row_piece, self);
    }
    if (1 - self->total <= ANALYTIC_CLOSED) return;
    sum->escaped += 1 - self->total;
    for (int quarter = 0; quarter < 4; quarter++) sum->sky += sky_of(self, view, quarter, occluders);
}

const FormFactorMethod FORM_FACTOR_ANALYTIC = {
    .name = "analytic",
    .summary = "exact: what faces hide of each other is cut away, pieces by Lambert's formula",
    .start = analytic_start,
    .row = exact_row,
};
