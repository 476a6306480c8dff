// wad_fixture.h - a small Doom map.
#ifndef TESTS_WAD_FIXTURE_H
#define TESTS_WAD_FIXTURE_H

#include "engine/sim/doors.h"
#include "tests/support/files/wad_builder.h"
#include "tests/support/support.h"

static const double UNIT = 0.031;  // metres a map unit

typedef struct Made {
    Arena arena;
    Building building;
    CellGraph graph;
    Doors doors;
    BodyWorld world;
    Body body;
} Made;

const char *wad_write_wad(Arena *arena, Bytes file);

const char *wad_write_map(Arena *arena, const WadMaker *maker);

void wad_open_file(Made *m, const char *path);

void wad_open_two_rooms(Made *m);

const Region *wad_region_of(const Building *b, int sector);

double wad_area_of_sector(const Building *b, int sector);

#endif
