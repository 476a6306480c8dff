// walk_fixture.h - frames that are verified.
#ifndef TESTS_WALK_FIXTURE_H
#define TESTS_WALK_FIXTURE_H

#include "engine/walk/walk_offscreen.h"
#include "tests/support/support.h"

typedef struct Walked {
    Arena arena;
    Building building;
    CellGraph graph;
    StabForest forest;
    float *doors;
} Walked;

void walk_check_open_building(Walked *w, const char *path);

#endif
