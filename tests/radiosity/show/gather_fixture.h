// gather_fixture.h - rooms whose light is gathered.
#ifndef TESTS_GATHER_FIXTURE_H
#define TESTS_GATHER_FIXTURE_H

#include "engine/core/parallel.h"
#include "radiosity/show/final_gather.h"
#include "tests/support/lit_fixture.h"

void gather_once(const GatherScene *scene, const GatherOptions *options, Vec3 p, Vec3 n, double out[3]);

// A room with a lamp and a cabinet 2 cm before its wall, in coarse elements, some as long as the cabinet is wide.
Lit *gather_room_with_slit(RadSolution *s);

// On the cabinet's back, at its edge and deep inside, on the wall opposite, in a corner, and in the mouth beneath.
enum { CLOSE_POINTS = 7 };

static const ViewPoint CLOSE[CLOSE_POINTS] = {
    {{1.6, 0.02, 0.9}, {0, -1, 0}, -1},  {{2.17, 0.02, 1.2}, {0, -1, 0}, -1},
    {{1.6, 0.02, 1.77}, {0, -1, 0}, -1}, {{1.6, 0, 1.6}, {0, 1, 0}, -1},
    {{1.1, 0, 0.4}, {0, 1, 0}, -1},      {{3.99, 1.5, 0}, {0, 0, 1}, -1},
    {{2.21, 0.01, 0}, {0, 0, 1}, -1},
};

void gather_all(const GatherScene *scene, const GatherOptions *options, double out[][3]);

#endif
