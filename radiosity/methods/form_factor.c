// form_factor.c - the table of methods, and the code that all methods share.
#include "radiosity/factors/form_factor.h"

#include <string.h>

#include "engine/core/error.h"
#include "radiosity/factors/near_faces.h"
#include "radiosity/factors/row.h"

extern const FormFactorMethod FORM_FACTOR_HEMISPHERE, FORM_FACTOR_HEMICUBE, FORM_FACTOR_HEMISPHERE_SCANLINE,
    FORM_FACTOR_HEMISPHERE_SCANLINES, FORM_FACTOR_HEMISPHERE_SCANLINES_FIT, FORM_FACTOR_HEMISPHERE_POLYLINE,
    FORM_FACTOR_ANALYTIC, FORM_FACTOR_RAY, FORM_FACTOR_RAY_DISC, FORM_FACTOR_RAY_HEMICUBE;
const FormFactorMethod *const FORM_FACTOR_METHODS[] = {
    &FORM_FACTOR_HEMISPHERE,
    &FORM_FACTOR_HEMICUBE,
    &FORM_FACTOR_HEMISPHERE_SCANLINE,
    &FORM_FACTOR_HEMISPHERE_SCANLINES,
    &FORM_FACTOR_HEMISPHERE_SCANLINES_FIT,
    &FORM_FACTOR_HEMISPHERE_POLYLINE,
    &FORM_FACTOR_ANALYTIC,
    &FORM_FACTOR_RAY,
    &FORM_FACTOR_RAY_DISC,
    &FORM_FACTOR_RAY_HEMICUBE,
    NULL,
};

struct FormFactor {
    const FormFactorMethod *method;
    const Mesh *mesh;
    void *self;
    RowSum sum;
    int32_t *item;  // [sample_count] of projective methods
    int *elements;  // [face_count] how many a face has
    FormFactorWork work;
};

FormFactorOptions form_factor_default_options(void) {
    static const double DEGREE = 3.14159265358979323846 / 180;
    return (FormFactorOptions){.resolution = 100, .edge_threshold = DEGREE};
}

const FormFactorMethod *form_factor_method(const char *name) {
    for (int i = 0; FORM_FACTOR_METHODS[i]; i++) {
        if (strcmp(FORM_FACTOR_METHODS[i]->name, name) == 0) return FORM_FACTOR_METHODS[i];
    }
    return NULL;
}

FormFactor *form_factor_new(const FormFactorMethod *method, const Mesh *mesh,
                            const FormFactorOptions *options, Arena *arena) {
    CORE_ASSERT(options->resolution >= 8 && options->resolution <= FORM_FACTOR_FINEST);
    FormFactor *self = ARENA_ARRAY(arena, FormFactor, 1);
    self->method = method;
    self->mesh = mesh;
    self->self = method->start(mesh, options, arena);
    row_start(&self->sum, mesh, arena);
    row_start_sky(&self->sum, options, arena);
    self->elements = ARENA_ARRAY(arena, int, mesh->face_count);
    for (int f = 0; f < mesh->face_count; f++) self->elements[f] = mesh->faces[f].element_count;
    if (method->projective) self->item = ARENA_ARRAY(arena, int32_t, method->samples(self->self)->count);
    return self;
}

void form_factor_end(FormFactor *self) {
    if (self->method->stop) self->method->stop(self->self);
}

static void count_drawn(FormFactor *self, const View *view) {
    self->work.faces_drawn += view->face_count;
    for (int i = 0; i < view->face_count; i++)
        self->work.elements_drawn += self->elements[view->faces[i].face];
}

const View *form_factor_look(const FormFactor *self, Viewer *viewer, const ViewPoint *from, Culling culling) {
    return self->method->clusters ? viewer_look_at_clusters(viewer, from, culling)
                                  : viewer_look(viewer, from, culling);
}

const FormFactorSamples *form_factor_samples(FormFactor *self) {
    CORE_ASSERT(self->method->projective);
    return self->method->samples(self->self);
}

const int32_t *form_factor_items(FormFactor *self, const View *view) {
    CORE_ASSERT(self->method->projective);
    self->method->items(self->self, view, self->item, &self->work);
    count_drawn(self, view);
    return self->item;
}

const Row *form_factor_row_shifted(FormFactor *self, const View *view, int shift) {
    self->sum.shift = shift;
    if (!self->method->row) {
        const int32_t *item = form_factor_items(self, view);
        row_of_items(&self->sum, view, self->method->samples(self->self), item);
    } else {
        self->method->row(self->self, view, &self->sum, &self->work);
        count_drawn(self, view);
    }
    if (self->method->mended) near_faces_mend(&self->sum, view);
    return row_finish(&self->sum);
}

const Row *form_factor_row(FormFactor *self, const View *view) {
    return form_factor_row_shifted(self, view, 0);
}

FormFactorWork form_factor_work(const FormFactor *self) { return self->work; }
