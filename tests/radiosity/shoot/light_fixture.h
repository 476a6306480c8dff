// light_fixture.h - boxes with lamps, and how right their light is.
#ifndef TESTS_LIGHT_FIXTURE_H
#define TESTS_LIGHT_FIXTURE_H

#include "tests/support/baked_fixture.h"
#include "tests/support/support.h"

static const Vec3 ROOM_LOW = {0, 0, 0}, ROOM_HIGH = {4, 3, 2.5};

// A room's polygons, as lit_box makes them.
enum { WEST, EAST, SOUTH, NORTH, FLOOR, CEILING, SIDES };

double light_sum3(const double v[3]);

void light_check_balance(const Lit *lit, const RadSolution *s);

BakedErrors light_check_traced(const char *name, Lit *lit, const RadSolution *s, int first, int end,
                               int count, long long most_paths);

#endif
