// shoot_fixture.h - rooms to shoot light in.
#ifndef TESTS_SHOOT_FIXTURE_H
#define TESTS_SHOOT_FIXTURE_H

#include "tests/support/lit_fixture.h"

RadOptions shoot_options_to(double residual);

// Relative difference of emitted and absorbed + escaped + unshot, the worst channel.
double shoot_lost_power(const Lit *lit, const RadSolution *s);

#endif
