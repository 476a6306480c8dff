// sampler_fixture.h - views that the sampler sees.
#ifndef TESTS_SAMPLER_FIXTURE_H
#define TESTS_SAMPLER_FIXTURE_H

#include "radiosity/factors/form_factor.h"
#include "tests/support/support.h"
#include "tests/support/view_fixture.h"

extern const FormFactorMethod FORM_FACTOR_HEMISPHERE, FORM_FACTOR_HEMICUBE;

typedef struct Method {
    const FormFactorMethod *method;
    void *self;
    const FormFactorSamples *samples;
    int32_t *item;
    FormFactorWork work;
} Method;

Method sampler_of_method_of(Arena *arena, int which, const ViewFixture *f, int resolution);

void sampler_of_see(Method *m, const View *view);

Vec3 sampler_of_sample(const Method *m, int i);

#endif
