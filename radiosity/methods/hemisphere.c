// hemisphere.c - form factors by the hemisphere base: a unit hemisphere's points lie over the unit disc, and equal areas of the
// disc are equal shares of the light that leaves the centre (Nusselt 1928; Doi & Itoh's hemisphere base). The samples are those of
// R x R pixels whose centres are inside the disc, with equal weights.
//
// Departure from Doi & Itoh: edges are exact great circles, not polylines, and depth is exact, not interpolated (sampler.h).
#include "radiosity/factors/row.h"
#include "radiosity/factors/sampler.h"

static void *hemisphere_start(const Mesh *mesh, const FormFactorOptions *options, Arena *arena) {
    SampleGrid grids[MOST_GRIDS];
    int count = grids_of_disc(options->resolution, grids);
    return sampler_new(mesh, options->lines, grids, count, GRIDS_TURN, arena);
}

static const FormFactorSamples *hemisphere_samples(void *self) { return sampler_samples(self); }

static void hemisphere_items(void *self, const View *view, int32_t *item, FormFactorWork *work) {
    sampler_draw(self, view, work);
    sampler_items(self, item);
}

static void hemisphere_row(void *self, const View *view, RowSum *sum, FormFactorWork *work) {
    sampler_draw(self, view, work);
    sampler_row(self, view, sum);
}

const FormFactorMethod FORM_FACTOR_HEMISPHERE = {
    .name = "hemisphere",
    .summary = "pixels of a hemisphere's base, edges and depth exact",
    .projective = true,
    .clusters = true,
    .mended = true,
    .start = hemisphere_start,
    .samples = hemisphere_samples,
    .items = hemisphere_items,
    .row = hemisphere_row,
};
