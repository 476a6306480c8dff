// hemicube.c - form factors by the hemicube (Cohen & Greenberg 1985): the pixels of a half cube about the point, R x R on its
// top and R x R/2 on each side, each with its delta form factor, 1 / (pi (x^2 + y^2 + 1)^2) times its area on the top and
// z / (pi (y^2 + z^2 + 1)^2) on the sides; scaled to sum 1.
//
// Departs from them: a pixel is decided by its direction's side of each edge's plane, so nothing is projected or clipped
// (sampler.h).
#include <math.h>

#include "radiosity/row.h"
#include "radiosity/sampler.h"

typedef struct Hemicube {
    Sampler *sampler;
} Hemicube;

enum { TOP = 4 };

// Sides look along x, y, -x, -y, each from the horizon up.
static bool on_cube(const SampleGrid *grid, int i, int j, double w[3], double *weight) {
    double u = 2 * (i + 0.5) / grid->width - 1;
    if (grid->which == TOP) {
        double v = 2 * (j + 0.5) / grid->height - 1, s = u * u + v * v + 1;
        w[0] = u, w[1] = v, w[2] = 1;
        *weight = 2.0 / grid->width / (s * s);
        return true;
    }
    static const double AHEAD[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    double z = (j + 0.5) / grid->height, s = u * u + z * z + 1;
    const double *a = AHEAD[grid->which];
    w[0] = a[0] - u * a[1];
    w[1] = a[1] + u * a[0];
    w[2] = z;
    *weight = z / grid->height / (s * s);
    return true;
}

static void *start(const Mesh *mesh, const FormFactorOptions *options, Arena *arena) {
    int r = options->resolution;
    SampleGrid grids[5] = {{r, r, TOP, on_cube}};
    for (int side = 0; side < 4; side++) grids[side + 1] = (SampleGrid){r, (r + 1) / 2, side, on_cube};
    Hemicube *self = ARENA_ARRAY(arena, Hemicube, 1);
    self->sampler = sampler_new(mesh, grids, 5, arena);
    return self;
}

static const FormFactorSamples *samples(void *self) { return sampler_samples(((Hemicube *)self)->sampler); }

static void items(void *self, const View *view, int32_t *item, FormFactorWork *work) {
    Sampler *sampler = ((Hemicube *)self)->sampler;
    sampler_draw(sampler, view, work);
    sampler_items(sampler, item);
}

static void row(void *self, const View *view, RowSum *sum, FormFactorWork *work) {
    Sampler *sampler = ((Hemicube *)self)->sampler;
    sampler_draw(sampler, view, work);
    sampler_row(sampler, view, sum);
}

const FormFactorMethod FORM_FACTOR_HEMICUBE = {
    .name = "hemicube",
    .summary = "pixels of a half cube with their delta form factors",
    .projective = true,
    .start = start,
    .samples = samples,
    .items = items,
    .row = row,
};
