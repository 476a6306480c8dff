// body_fixture.h - a body in a building.
#ifndef TESTS_BODY_FIXTURE_H
#define TESTS_BODY_FIXTURE_H

#include "engine/sim/collision_check.h"
#include "engine/sim/doors.h"
#include "tests/support/support.h"

typedef struct Walker {
    Arena arena;
    Building building;
    CellGraph graph;
    Doors doors;
    BodyWorld world;
    CollisionCheck *check;
    Body body;
} Walker;

void body_check_open_cells(Walker *w);

void body_check_open_file(Walker *w, const char *path);

// A building in words.
void body_check_open_plan(Walker *w, const char *plan);

void body_check_stand(Walker *w, double x, double y, double z);

void body_check_expect_free(Walker *w, const char *where);

// Expects to be stopped within this much of the way, in the direction of the way.
void body_check_expect_stop(Walker *w, double x, double y, double after, const char *where);

#define HEAD "plan 1\nmaterial m #808080\n"

// Two rooms with a wall of 0.2 m between, and a passage.
#define ROOMS                                                                                                \
    HEAD "storey s floor 0 height 2.6\nroom a 0,0 4,0 4,4 0,4 wall 0.2\nroom b 4.2,0 8.2,0 8.2,4 4.2,4 "     \
         "wall 0.2\n"

#endif
