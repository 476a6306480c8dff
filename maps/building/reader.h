// reader.h - the interface of a reader of building files; maps.c has the table of all.
#ifndef MAPS_READER_H
#define MAPS_READER_H

#include "engine/core/file.h"
#include "maps/building/building.h"

// A file format: one reader, one row in the table in maps.c.
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

#endif
