// soup_doors.h - the doors of a soup.
#ifndef MAPS_SOUP_DOORS_H
#define MAPS_SOUP_DOORS_H

#include "maps/building/building.h"

// Makes an opening with a leaf of each upright slab of the size of a door whose object or material is called a door,
// and moves its polygons into an object of its own. Run after the reader of a soup, before building_check.
void soup_find_doors(Arena *arena, Building *b);

#endif
