// doors_fixture.h - a building with doors, and the leaves of these.
#ifndef TESTS_DOORS_FIXTURE_H
#define TESTS_DOORS_FIXTURE_H

#include "engine/sim/doors.h"
#include "tests/support/support.h"

typedef struct Made {
    Arena arena;
    Building building;
    CellGraph graph;
    Doors doors;
    BodyWorld world;
    Body body;
} Made;

// The rooms with these doors, closed; the body in the middle of the western one.
void doors_check_make(Made *m, const char *doors);

#endif
