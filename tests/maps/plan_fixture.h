// plan_fixture.h - plans as text.
#ifndef TESTS_PLAN_FIXTURE_H
#define TESTS_PLAN_FIXTURE_H

#include "maps/maps.h"
#include "tests/support/support.h"

extern const MapsReader MAPS_READER_PLAN;

// Two rooms 4 x 4 m, 0.2 m apart; what a case adds begins on line 7.
static const char HEAD[] = "plan 1\nmaterial red #FF0000\nstorey s floor 1 height 3\n"
                           "room a 0,0 4,0 4,4 0,4 wall 0.2\nroom b 4.2,0 8,0 8,4 4.2,4 wall 0.2\n"
                           "model m\n  box -1,-1,0 1,1,1 red\nend\n";

bool plan_read_bytes(Arena *arena, const void *data, size_t size, Building *b, Error *error);

bool plan_read_text(Arena *arena, const char *text, Building *b, Error *error);

// HEAD and more lines, which must read.
void plan_read_more(Arena *arena, const char *more, Building *b);

#endif
