// hemisphere.c - form factors by the hemisphere base: a unit hemisphere's points lie over the unit disc, and equal areas of the
// disc are equal shares of the light that leaves the centre (Nusselt 1928; Doi & Itoh's hemisphere base). The samples are those of
// R x R pixels whose centres are inside the disc, with equal weights.
//
// Departure from Doi & Itoh: edges are exact great circles, not polylines, and depth is exact, not interpolated (sampler.h).
#include "radiosity/factors/row.h"
#include "radiosity/factors/sampler.h"

// Finer samples need no shifts.
enum { FINEST_SHIFTED = 100 };

typedef struct Hemisphere {
    Sampler *plain, *shifted[FORM_FACTOR_SHIFTS];
} Hemisphere;

static void *hemisphere_start(const Mesh *mesh, const FormFactorOptions *options, Arena *arena) {
    Hemisphere *self = ARENA_ARRAY(arena, Hemisphere, 1);
    SampleGrid grids[MOST_GRIDS];
    int count = grids_of_disc(options->resolution, grids);
    self->plain = sampler_new(mesh, options->lines, grids, count, GRIDS_TURN, arena);
    for (int i = 0; i < FORM_FACTOR_SHIFTS; i++) {
        self->shifted[i] = self->plain;
        if (!options->shifts || options->resolution > FINEST_SHIFTED) continue;
        count = grids_of_shifted_disc(options->resolution, i, grids);
        self->shifted[i] = sampler_new_like(self->plain, grids, count, arena);
    }
    return self;
}

static const FormFactorSamples *hemisphere_samples(void *self) {
    const Hemisphere *h = self;
    return sampler_samples(h->plain);
}

static void hemisphere_items(void *self, const View *view, int32_t *item, FormFactorWork *work) {
    const Hemisphere *h = self;
    sampler_draw(h->plain, view, work);
    sampler_items(h->plain, item);
}

static void hemisphere_row(void *self, const View *view, RowSum *sum, FormFactorWork *work) {
    const Hemisphere *h = self;
    sampler_draw(h->shifted[sum->shift], view, work);
    sampler_row(h->shifted[sum->shift], view, sum);
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
