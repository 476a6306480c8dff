// maps.h - reading building files of any known format.
#ifndef MAPS_MAPS_H
#define MAPS_MAPS_H

#include "engine/core/file.h"
#include "maps/building.h"

// A file format: one reader a file, one row in the table in maps.c.
typedef struct MapsReader {
    const char *name;                  // "plan"
    const char *suffixes;              // ".plan" or ".sh3d .xml", separated by blanks
    const char *summary;               // for --help
    bool (*recognise)(Bytes content);  // by content alone
    // `out` is empty but for the `map` wanted; a reader of files with several leaves there the name of the one read.
    // A reader of files that refer to others leaves in `hash` a hash of those it read.
    bool (*read)(const char *path, Bytes content, Arena *arena, Building *out, Error *error);
    bool has_maps;  // its files hold several maps
} MapsReader;

extern const MapsReader *const MAPS_READERS[];  // ends with NULL

// Reads a building with the reader that suffix and content choose; on success the building passes
// building_check. Bad input: false and one sentence.
bool maps_read(const char *path, Arena *arena, Building *out, Error *error);
// The same of a file that holds several maps, by name; NULL for the first. Refuses a name where there is but one.
bool maps_read_map(const char *path, const char *map, Arena *arena, Building *out, Error *error);

#endif
