// sums_fixture.h - what sums are taken of.
#ifndef TESTS_SUMS_FIXTURE_H
#define TESTS_SUMS_FIXTURE_H

#include "tests/support/draft_fixture.h"
#include "tests/support/files/hostile.h"
#include "tests/support/sums.h"
#include "tests/support/support.h"
#include "visibility/pairs/pairs.h"

static const char *const FILES[] = {
    "build/maps/two-rooms.plan", "build/maps/house.plan", "build/maps/house.sh3d", "build/maps/flat.Home.xml",
    "build/maps/hillside.sh3d",  "build/maps/villa.sh3d", "build/maps/office.plan"};

enum { FILE_COUNT = sizeof FILES / sizeof *FILES };

void sums_of_sum_polygons(SumFile *f, const Object *objects, int object_count, const Polygon *polygons,
                          int polygon_count, const Vec3 *vertices, int vertex_count);

void sums_of_read_building(const char *path, Arena *arena, Building *b);

// Reads a small file of a hostile kind; false where even that is refused.
bool sums_of_read_hostile(const HostileKind *k, const char *folder, Arena *arena, Building *out);

// A plan with all that makes plans hard; false where nothing in it is enclosed.
bool sums_of_random_plan(int seed, Draft *d);

#endif
