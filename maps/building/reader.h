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
    // `out` is empty except for `map`, the map wanted, and `file_size`. A reader of files that hold several maps sets `map` to the
    // name of the map read. A reader of files that refer to other files sets `hash` to a hash of the other files read.
    bool (*read)(const char *path, Bytes content, Arena *arena, Building *out, Error *error);
    bool has_maps;  // its files hold several maps
} MapsReader;

#endif
