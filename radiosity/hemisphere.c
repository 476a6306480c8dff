// hemisphere.c - form factors by the hemisphere base: a unit hemisphere's points lie over the unit disc, and equal areas of the
// disc are equal shares of the light that leaves the centre (Nusselt 1928; Doi & Itoh's hemisphere base). The samples are the
// centres of R x R pixels over the disc, those inside it, with equal weights.
//
// Departs from Doi & Itoh: edges are exact great circles, not polylines, and depth is exact, not interpolated (sampler.h).
#include <math.h>

#include "radiosity/row.h"
#include "radiosity/sampler.h"

static bool over_disc(const SampleGrid *grid, int i, int j, double w[3], double *weight) {
    w[0] = 2 * (i + 0.5) / grid->width - 1;
    w[1] = 2 * (j + 0.5) / grid->height - 1;
    double left = 1 - w[0] * w[0] - w[1] * w[1];
    if (left <= 0) return false;
    w[2] = sqrt(left);
    *weight = 1;
    return true;
}

static void *start(const Mesh *mesh, const FormFactorOptions *options, Arena *arena) {
    SampleGrid grid = {options->resolution, options->resolution, 0, over_disc};
    return sampler_new(mesh, &grid, 1, arena);
}

static const FormFactorSamples *samples(void *self) { return sampler_samples(self); }

static void items(void *self, const View *view, int32_t *item, FormFactorWork *work) {
    sampler_draw(self, view, work);
    sampler_items(self, item);
}

static void row(void *self, const View *view, RowSum *sum, FormFactorWork *work) {
    sampler_draw(self, view, work);
    sampler_row(self, view, sum);
}

const FormFactorMethod FORM_FACTOR_HEMISPHERE = {
    .name = "hemisphere",
    .summary = "pixels of a hemisphere's base, edges and depth exact",
    .projective = true,
    .start = start,
    .samples = samples,
    .items = items,
    .row = row,
};
