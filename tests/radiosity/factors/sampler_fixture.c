// sampler_fixture.c - see the header.
#include "tests/radiosity/factors/sampler_fixture.h"

#include <criterion/criterion.h>
#include <criterion/parameterized.h>

#include "radiosity/factors/form_factor.h"
#include "tests/support/support.h"
#include "tests/support/view_fixture.h"

Method sampler_of_method_of(Arena *arena, int which, const ViewFixture *f, int resolution) {
    FormFactorOptions options = {.resolution = resolution};
    Method m = {.method = which ? &FORM_FACTOR_HEMICUBE : &FORM_FACTOR_HEMISPHERE};
    m.self = m.method->start(&f->mesh, &options, arena);
    m.samples = m.method->samples(m.self);
    m.item = ARENA_ARRAY(arena, int32_t, m.samples->count);
    return m;
}

void sampler_of_see(Method *m, const View *view) { m->method->items(m->self, view, m->item, &m->work); }

Vec3 sampler_of_sample(const Method *m, int i) {
    return vec3((double)m->samples->x[i], (double)m->samples->y[i], (double)m->samples->z[i]);
}
