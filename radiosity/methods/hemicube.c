// hemicube.c - form factors by the hemicube (Cohen & Greenberg 1985): the pixels of a half cube about the point, R x R on its
// top and R x R/2 on each side, each with its delta form factor, 1 / (pi (x^2 + y^2 + 1)^2) times its area on the top and
// z / (pi (y^2 + z^2 + 1)^2) on the sides; scaled to sum 1.
//
// Departs from them: a pixel is decided by its direction's side of each edge's plane, so nothing is projected or clipped
// (sampler.h). A hidden-surface method may fill the sides instead (hemicube_hidden.h).
#include "radiosity/factors/row.h"
#include "radiosity/factors/sampler.h"
#include "radiosity/methods/hemicube_hidden.h"

typedef struct Hemicube {
    Sampler *sampler;
    HemicubeHidden *hidden;  // instead of the sampler, where a method was named
    int32_t *item;           // of the hidden
} Hemicube;

static void *hemicube_start(const Mesh *mesh, const FormFactorOptions *options, Arena *arena) {
    SampleGrid grids[MOST_GRIDS];
    Hemicube *self = ARENA_ARRAY(arena, Hemicube, 1);
    if (options->hidden) {
        self->hidden = hemicube_hidden_new(mesh, options->hidden, options->resolution, arena);
        self->item = ARENA_ARRAY(arena, int32_t, hemicube_hidden_samples(self->hidden)->count);
    } else {
        int count = grids_of_hemicube(options->resolution, grids);
        self->sampler = sampler_new(mesh, options->lines, grids, count, 0, arena);
    }
    return self;
}

static void stop(void *data) {
    Hemicube *self = data;
    if (self->hidden) hemicube_hidden_end(self->hidden);
}

static const FormFactorSamples *hemicube_samples(void *data) {
    Hemicube *self = data;
    return self->hidden ? hemicube_hidden_samples(self->hidden) : sampler_samples(self->sampler);
}

static void hemicube_items(void *data, const View *view, int32_t *item, FormFactorWork *work) {
    Hemicube *self = data;
    if (self->hidden) {
        hemicube_hidden_items(self->hidden, view, item, work);
        return;
    }
    sampler_draw(self->sampler, view, work);
    sampler_items(self->sampler, item);
}

static void hemicube_row(void *data, const View *view, RowSum *sum, FormFactorWork *work) {
    Hemicube *self = data;
    if (self->hidden) {
        hemicube_hidden_items(self->hidden, view, self->item, work);
        row_of_items(sum, view, hemicube_hidden_samples(self->hidden), self->item);
        return;
    }
    sampler_draw(self->sampler, view, work);
    sampler_row(self->sampler, view, sum);
}

const FormFactorMethod FORM_FACTOR_HEMICUBE = {
    .name = "hemicube",
    .summary = "pixels of a half cube with their delta form factors",
    .projective = true,
    .mended = true,
    .start = hemicube_start,
    .stop = stop,
    .samples = hemicube_samples,
    .items = hemicube_items,
    .row = hemicube_row,
};
