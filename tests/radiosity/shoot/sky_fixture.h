// sky_fixture.h - scenes under the sky.
#ifndef TESTS_SKY_FIXTURE_H
#define TESTS_SKY_FIXTURE_H

#include "radiosity/show/reconstruct.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

static const double SKY[3] = {10, 20, 30};

RadOptions sky_options_of(Culling culling, int threads);

RadSolution sky_shone(Lit *lit, const RadOptions *options);

// Emitted light was absorbed, escaped, or is left.
void sky_check_conserved(const Lit *lit, const RadSolution *s);

Lit *sky_read_plan_with(const char *rest, double element, int per_patch);

#endif
