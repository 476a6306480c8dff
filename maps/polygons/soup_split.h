// soup_split.h - large objects of a soup in parts that can be culled.
#ifndef MAPS_SOUP_SPLIT_H
#define MAPS_SOUP_SPLIT_H

#include "maps/building/building.h"

// An object of a soup with more polygons than this is split into parts.
enum { SOUP_PART_POLYGONS = 256 };

// Splits each large object, except leaves of doors and lamps, into objects of the same name and kind. Polygons connected by
// common corners stay together, unless they are a shell that spans the building, and neighbours are gathered into objects of up to
// SOUP_PART_POLYGONS polygons. The order of polygons changes, their corners do not. Run after soup_find_doors.
void soup_split(Arena *arena, Building *b);

#endif
