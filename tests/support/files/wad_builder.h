// wad_builder.h - small Doom WADs made in memory: by the tests of their reader, and as seeds to fuzz it with.
#ifndef TESTS_WAD_BUILDER_H
#define TESTS_WAD_BUILDER_H

#include "engine/core/file.h"

// One map. Numbers are those of the lumps.
typedef struct WadMaker {
    Arena *arena;
    unsigned char *vertices, *lines, *sides, *sectors, *things;
    int vertex_size, line_size, side_size, sector_size, thing_size;  // bytes
    int vertex_capacity, line_capacity, side_capacity, sector_capacity, thing_capacity;
} WadMaker;

int wad_vertex(WadMaker *w, int x, int y);
int wad_sector(WadMaker *w, int floor, int ceiling, const char *ceiling_flat, int tag);
// From point to point, its right side facing sector `front`; -1: no side.
int wad_line(WadMaker *w, int x1, int y1, int x2, int y2, int front, int back, int special, int tag);
void wad_thing(WadMaker *w, int x, int y, int angle, int type);

// Two rooms with a door between them, a lift from the second up to a court under the sky, and in the first a pillar of
// slanted walls. Sectors: WAD_ROOM ...
enum { WAD_ROOM, WAD_DOOR_SECTOR, WAD_HALL, WAD_LIFT_SECTOR, WAD_COURT };
void wad_two_rooms(WadMaker *w);

// A file of maps with these names; `with` (or NULL): one more lump after the last.
Bytes wad_file(const WadMaker *maps, const char *const *names, int count, const char *with);
// The same file with pictures: a palette whose colour i is (i, 255 - i, i / 2); flats FLAT and CEIL, whose texel (x, y) has colour
// x + 2 y; wall textures MIDDLE, 64 x 96, of two patches side by side, LOWER, 64 x 64, and UPPER, 64 x 72, of one patch, and the sky
// SKY1, 256 x 128. A patch is 32 x 128; its texel (x, y) has colour x + y.
Bytes wad_with_pictures(Arena *arena, Bytes file);
// The place of a lump's data in such a file, -1 without.
long wad_lump(Bytes file, const char *name, long *size);

// The file of those two rooms, with pictures, in which each four bytes put two others somewhere.
Bytes wad_spoilt(Arena *arena, const unsigned char *data, size_t size);

#endif
