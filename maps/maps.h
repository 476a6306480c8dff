// maps.h - reading building files of any known format.
#ifndef MAPS_MAPS_H
#define MAPS_MAPS_H

#include "maps/building/reader.h"

extern const MapsReader *const MAPS_READERS[];  // ends with NULL

// Reads a building with the reader that suffix and content choose; on success the building passes
// building_check. Bad input: false and one sentence.
bool maps_read(const char *path, Arena *arena, Building *out, Error *error);
// The same of a file that holds several maps, by name; NULL for the first. Refuses a name where there is but one.
bool maps_read_map(const char *path, const char *map, Arena *arena, Building *out, Error *error);

#endif
