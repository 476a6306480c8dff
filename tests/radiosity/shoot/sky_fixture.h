// sky_fixture.h - scenes under the sky.
#ifndef TESTS_SKY_FIXTURE_H
#define TESTS_SKY_FIXTURE_H

#include "radiosity/show/reconstruct.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

static const double SKY[3] = {10, 20, 30};

RadOptions sky_options_of(Culling culling, int threads);

RadSolution sky_shone(Lit *lit, const RadOptions *options);
RadSolution sky_day_shone(Lit *lit, const Daylight *day, const RadOptions *options);

// Emitted light was absorbed, escaped, or is left.
void sky_check_conserved(const Lit *lit, const RadSolution *s);

Lit *sky_read_plan_with(const char *rest, double element, int per_patch);

// A room with one window of this size, a table before it, a garden and a wall out there.
Lit *sky_room_with_window(double width, double height, double element);

// Relative errors of the light that points indoors gather, against path tracing, in order; points nearly in the dark aside. `make soak`
// looks at all points, `make test` at a third of them.
enum { SKY_POINTS = 24 };
int sky_point_count(void);
int sky_errors_of(Lit *lit, const RadSolution *s, double errors[SKY_POINTS]);

#endif
