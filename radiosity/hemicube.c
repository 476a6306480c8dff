// hemicube.c - form factors by the hemicube (Cohen & Greenberg 1985): the pixels of a half cube about the point, R x R on its
// top and R x R/2 on each side, each with its delta form factor, 1 / (pi (x^2 + y^2 + 1)^2) times its area on the top and
// z / (pi (y^2 + z^2 + 1)^2) on the sides; scaled to sum 1.
//
// Departs from them: a pixel is decided by its direction's side of each edge's plane, so nothing is projected or clipped
// (sampler.h).
#include "radiosity/row.h"
#include "radiosity/sampler.h"

typedef struct Hemicube {
    Sampler *sampler;
} Hemicube;

static void *start(const Mesh *mesh, const FormFactorOptions *options, Arena *arena) {
    SampleGrid grids[MOST_GRIDS];
    Hemicube *self = ARENA_ARRAY(arena, Hemicube, 1);
    self->sampler = sampler_new(mesh, grids, grids_of_hemicube(options->resolution, grids), 0, arena);
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
