// soup_split.h - large objects of a soup in parts that can be culled.
#ifndef MAPS_SOUP_SPLIT_H
#define MAPS_SOUP_SPLIT_H

#include "maps/building/building.h"

// An object of a soup with more polygons than this is parted.
enum { SOUP_PART_POLYGONS = 256 };

// Parts each large object, but for leaves of doors and lamps, into objects of its name and kind: polygons that hang
// together by common corners stay together, unless they are a shell that spans the building, and neighbours are gathered up to
// SOUP_PART_POLYGONS polygons. Polygons change their order, none its corners. Run after soup_find_doors.
void soup_split(Arena *arena, Building *b);

#endif
