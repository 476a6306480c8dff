// maps.h - reading building files of any known format.
#ifndef MAPS_MAPS_H
#define MAPS_MAPS_H

#include "maps/building/reader.h"

// Bytes. A home with all its furniture has some 100 MB, a building model of a campus a gigabyte.
enum { MAPS_LARGEST_FILE = INT32_MAX };

extern const MapsReader *const MAPS_READERS[];  // ends with NULL

// Reads a building with the reader that fits the file's suffix and content. On success the building passes
// building_check; on bad input returns false and sets `error` to one sentence.
bool maps_read(const char *path, Arena *arena, Building *out, Error *error);
// The same for one map of a file that may hold several; `map` NULL: the first. A name is refused for a format with one map a file.
bool maps_read_map(const char *path, const char *map, Arena *arena, Building *out, Error *error);

#endif
