// maps.c - the table of readers, and the choice among them: the reader whose suffix and content both fit, else
// the one whose content fits, else the one whose suffix fits (it tells best which fault the file has).
#include "maps/maps.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "engine/core/memory.h"
#include "maps/photometry/photometry_file.h"
#include "maps/polygons/soup_doors.h"
#include "maps/polygons/soup_split.h"

extern const MapsReader MAPS_READER_PLAN, MAPS_READER_SH3D, MAPS_READER_PRT, MAPS_READER_QUADS,
    MAPS_READER_OBJ, MAPS_READER_GLTF, MAPS_READER_WAD, MAPS_READER_QUAKE, MAPS_READER_FOREIGN,
    MAPS_READER_IFC;
const MapsReader *const MAPS_READERS[] = {&MAPS_READER_PLAN,
                                          &MAPS_READER_SH3D,
                                          &MAPS_READER_PRT,
                                          &MAPS_READER_QUADS,
                                          &MAPS_READER_OBJ,
                                          &MAPS_READER_GLTF,
                                          &MAPS_READER_WAD,
                                          &MAPS_READER_QUAKE,
                                          &MAPS_READER_IFC,
                                          &MAPS_READER_FOREIGN,
                                          NULL};

// Whether `path` ends in one of the suffixes separated by blanks.
static bool suffix_fits(const char *path, const char *suffixes) {
    size_t length = strlen(path);
    for (const char *s = suffixes; *s;) {
        size_t n = strcspn(s, " ");
        if (n > 0 && length > n && strncasecmp(path + length - n, s, n) == 0) return true;
        s += n + strspn(s + n, " ");
    }
    return false;
}

static const MapsReader *choose(const char *path, Bytes content) {
    const MapsReader *by_content = NULL, *by_suffix = NULL;
    for (int i = 0; MAPS_READERS[i]; i++) {
        const MapsReader *reader = MAPS_READERS[i];
        bool suffix = suffix_fits(path, reader->suffixes), fits = reader->recognise(content);
        if (suffix && fits) return reader;
        if (fits && !by_content) by_content = reader;
        if (suffix && !by_suffix) by_suffix = reader;
    }
    return by_content ? by_content : by_suffix;
}

static bool refuse_unknown(const char *path, Error *error) {
    char known[256] = "";
    for (int i = 0; MAPS_READERS[i]; i++) {
        size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", used ? " " : "", MAPS_READERS[i]->suffixes);
    }
    return error_set(error, "%s: not a building file of a known format (known are %s)", path, known);
}

bool maps_read(const char *path, Arena *arena, Building *out, Error *error) {
    return maps_read_map(path, NULL, arena, out, error);
}

bool maps_read_map(const char *path, const char *map, Arena *arena, Building *out, Error *error) {
    Bytes content;
    memset(out, 0, sizeof *out);
    if (!file_read(path, MAPS_LARGEST_FILE, arena, &content, error)) return false;
    const MapsReader *reader = choose(path, content);
    if (!reader) return refuse_unknown(path, error);
    if (map && !reader->has_maps) {
        return error_set(error,
                         "%s: holds one building only (a map, `%s`, is named for formats that hold several)",
                         path, map);
    }
    out->map = map;
    out->file_size = (double)content.size;
    if (!reader->read(path, content, arena, out, error) || !memory_within(error)) return false;
    out->source = arena_string(arena, path);
    out->hash = file_hash(content.data, content.size, out->hash);
    if (out->map) out->hash = file_hash(out->map, strlen(out->map), out->hash);
    if (!photometry_of_lamps(path, arena, out, error)) return false;
    if (out->form == FORM_SOUP) {
        soup_find_doors(arena, out);
        if (memory_within(error)) soup_split(arena, out);
        if (!memory_within(error)) return false;
    }
    building_fit(arena, out);
    const char *fault;
    int faults = building_check(out, arena, &fault, 1);
    if (faults > 0)
        return error_set(error, "%s: the building as read is faulty: %s (%d faults in all)", path, fault,
                         faults);
    return true;
}
