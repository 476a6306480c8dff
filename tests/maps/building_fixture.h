// building_fixture.h - a building that is sound, and faults in it.
#ifndef TESTS_BUILDING_FIXTURE_H
#define TESTS_BUILDING_FIXTURE_H

#include "maps/building/building.h"

int building_faults_of(const Building *b, Arena *arena, const char *expected);

void building_add_ring(Arena *arena, Building *b, const double *xy, int count);

Region *building_add_region(Arena *arena, Building *b, double z0, double z1, const double *xy, int count);

// Two rooms that share the edge x = 4, the second with a hole.
Building building_sound_building(Arena *arena);

#endif
