// wad_map.c - the lumps of a Doom map: found in the directory of the file, their records read and every index checked.
//
// Layout: little-endian. Header, lumps, directory; a map is an empty lump of its name and the lumps that follow it (id
// Software 1993; Hexen's and UDMF maps differ and are refused).
#include <ctype.h>
#include <stdio.h>

#include "maps/doom/wad.h"

enum { HEADER = 12, ENTRY = 16, NAME = 8 };
enum { THING = 10, LINE = 14, SIDE = 30, VERTEX = 4, SECTOR = 26 };  // bytes a record
enum { NONE = 0xFFFF };                                              // instead of a side's number
enum { MOST_RECORDS = 0xFFFF };                                      // of a kind: their numbers have 16 bits

static int u16(const unsigned char *p) { return p[0] | p[1] << 8; }
static int i16(const unsigned char *p) { return (int16_t)u16(p); }
static long long i32(const unsigned char *p) {
    return (int32_t)((uint32_t)u16(p) | (uint32_t)u16(p + 2) << 16);
}

void wad_name(const unsigned char *p, char out[NAME + 1]) {
    int length = 0;
    while (length < NAME && p[length]) {
        out[length] = isgraph(p[length]) ? (char)toupper(p[length]) : '?';
        length++;
    }
    memset(out + length, 0, (size_t)(NAME + 1 - length));
}

Bytes wad_lump_bytes(const WadMap *map, int lump, char name[NAME + 1]) {
    const unsigned char *entry = map->directory + (size_t)lump * ENTRY;
    long long at = i32(entry), size = i32(entry + 4), all = (long long)map->content.size;
    wad_name(entry + 8, name);
    if (at < 0 || size <= 0 || at > all || size > all - at) return (Bytes){0};
    return (Bytes){map->content.data + at, (size_t)size};
}

// ---- the directory

typedef struct Directory {
    const char *path;
    Bytes content;
    const unsigned char *entries;
    int count;
} Directory;

static void lump_name(const Directory *d, int lump, char out[NAME + 1]) {
    wad_name(d->entries + (size_t)lump * ENTRY + 8, out);
}

static bool lump_is(const Directory *d, int lump, const char *name) {
    char found[NAME + 1];
    if (lump >= d->count) return false;
    lump_name(d, lump, found);
    return strcmp(found, name) == 0;
}

static bool open_directory(const char *path, Bytes content, Directory *out, Error *error) {
    const unsigned char *data = content.data;
    if (content.size < HEADER || (memcmp(data, "IWAD", 4) != 0 && memcmp(data, "PWAD", 4) != 0)) {
        return error_set(error,
                         "%s: does not begin with a WAD's header of %d bytes (allowed: IWAD or PWAD, then "
                         "two numbers)",
                         path, HEADER);
    }
    long long count = i32(data + 4), at = i32(data + 8), size = (long long)content.size;
    if (at < 0 || at > size || count < 0 || count > (size - at) / ENTRY) {
        return error_set(
            error,
            "%s: its directory of %lld lumps at byte %lld does not lie within the file of %lld bytes "
            "(allowed: %d bytes a lump)",
            path, count, at, size, ENTRY);
    }
    *out = (Directory){path, content, data + at, (int)count};
    return true;
}

// A map's name is that of the lump before its own.
static bool is_map(const Directory *d, int lump) {
    return lump_is(d, lump + 1, "THINGS") || lump_is(d, lump + 1, "TEXTMAP");
}

static bool no_such_map(const Directory *d, const char *name, Error *error) {
    char list[512] = "";
    size_t used = 0;
    for (int i = 0; i < d->count; i++) {
        char map[NAME + 1];
        if (!is_map(d, i)) continue;
        lump_name(d, i, map);
        if (used + sizeof map + 8 > sizeof list) {
            memcpy(list + used, ", ...", 6);
            break;
        }
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%s", used ? ", " : "", map);
    }
    if (used == 0)
        return error_set(error, "%s: none of its %d lumps begins a map (allowed: a name, then THINGS)",
                         d->path, d->count);
    return error_set(error, "%s: there is no map `%s` (allowed: %s)", d->path, name, list);
}

static bool same_name(const char *a, const char *b) {
    for (; *a && *b; a++, b++) {
        if (toupper((unsigned char)*a) != toupper((unsigned char)*b)) return false;
    }
    return *a == *b;
}

// The lump that begins a map, or -1.
static int find_map(const Directory *d, const char *name) {
    for (int i = 0; i < d->count; i++) {
        char map[NAME + 1];
        lump_name(d, i, map);
        if (is_map(d, i) && (!name || same_name(map, name))) return i;
    }
    return -1;
}

// ---- lumps

typedef struct Lump {
    const unsigned char *data;
    int count;  // of records
} Lump;

typedef struct Reader {
    Directory directory;
    int marker;
    const char *name;  // of the map
    Arena *arena;
    Error *error;
    WadMap *map;
} Reader;

static bool fail_record(const Reader *r, const char *lump, int index, const char *what, long long found,
                        const char *allowed, long long most) {
    return error_set(r->error, "%s: %s, %s %d: %s %lld (allowed: %s %lld)", r->directory.path, r->name, lump,
                     index, what, found, allowed, most);
}

// The lump of this name among those of the map.
static bool find_lump(const Reader *r, const char *name, int record, Lump *out) {
    static const char *const OF_A_MAP[] = {"THINGS", "LINEDEFS", "SIDEDEFS", "VERTEXES",
                                           "SEGS",   "SSECTORS", "NODES",    "SECTORS",
                                           "REJECT", "BLOCKMAP", "SCRIPTS",  "BEHAVIOR"};
    const Directory *d = &r->directory;
    for (int i = r->marker + 1; i < d->count; i++) {
        bool ours = false;
        for (size_t k = 0; k < sizeof OF_A_MAP / sizeof *OF_A_MAP; k++)
            ours = ours || lump_is(d, i, OF_A_MAP[k]);
        if (!ours) break;
        if (!lump_is(d, i, name)) continue;
        const unsigned char *entry = d->entries + (size_t)i * ENTRY;
        long long at = i32(entry), size = i32(entry + 4), all = (long long)d->content.size;
        if (at < 0 || size < 0 || at > all || size > all - at) {
            return error_set(
                r->error, "%s: %s, lump %s: %lld bytes at byte %lld do not lie within the file of %lld bytes",
                d->path, r->name, name, size, at, all);
        }
        if (size % record != 0 || size / record > MOST_RECORDS) {
            return error_set(r->error,
                             "%s: %s, lump %s: %lld bytes (allowed: up to %d records of %d bytes each)",
                             d->path, r->name, name, size, MOST_RECORDS, record);
        }
        *out = (Lump){d->content.data + at, (int)(size / record)};
        return true;
    }
    return error_set(r->error,
                     "%s: %s has no lump %s (allowed: THINGS, LINEDEFS, SIDEDEFS, VERTEXES, SECTORS)",
                     d->path, r->name, name);
}

static bool read_vertices(Reader *r) {
    Lump lump;
    if (!find_lump(r, "VERTEXES", VERTEX, &lump)) return false;
    WadMap *map = r->map;
    map->vertex_count = lump.count;
    map->vertices = ARENA_ARRAY(r->arena, WadPoint, lump.count);
    for (int i = 0; i < lump.count; i++) {
        const unsigned char *p = lump.data + (size_t)i * VERTEX;
        map->vertices[i] = (WadPoint){i16(p), i16(p + 2), 1};
    }
    return true;
}

static bool read_sectors(Reader *r) {
    Lump lump;
    if (!find_lump(r, "SECTORS", SECTOR, &lump)) return false;
    WadMap *map = r->map;
    map->sector_count = lump.count;
    map->sectors = ARENA_ARRAY(r->arena, WadSector, lump.count);
    for (int i = 0; i < lump.count; i++) {
        const unsigned char *p = lump.data + (size_t)i * SECTOR;
        WadSector *s = &map->sectors[i];
        *s = (WadSector){.floor = i16(p),
                         .ceiling = i16(p + 2),
                         .light = i16(p + 20),
                         .special = u16(p + 22),
                         .tag = u16(p + 24)};
        wad_name(p + 4, s->floor_flat);
        wad_name(p + 12, s->ceiling_flat);
    }
    return true;
}

static bool read_sides(Reader *r) {
    Lump lump;
    if (!find_lump(r, "SIDEDEFS", SIDE, &lump)) return false;
    WadMap *map = r->map;
    map->side_count = lump.count;
    map->sides = ARENA_ARRAY(r->arena, WadSide, lump.count);
    for (int i = 0; i < lump.count; i++) {
        const unsigned char *p = lump.data + (size_t)i * SIDE;
        WadSide *s = &map->sides[i];
        wad_name(p + 4, s->upper);
        wad_name(p + 12, s->lower);
        wad_name(p + 20, s->middle);
        s->offset[0] = i16(p), s->offset[1] = i16(p + 2);
        s->sector = u16(p + 28);
        if (s->sector >= map->sector_count)
            return fail_record(r, "sidedef", i, "sector", s->sector, "0 to", map->sector_count - 1);
    }
    return true;
}

static bool read_lines(Reader *r) {
    Lump lump;
    if (!find_lump(r, "LINEDEFS", LINE, &lump)) return false;
    WadMap *map = r->map;
    map->line_count = lump.count;
    map->lines = ARENA_ARRAY(r->arena, WadLine, lump.count);
    for (int i = 0; i < lump.count; i++) {
        const unsigned char *p = lump.data + (size_t)i * LINE;
        WadLine *line = &map->lines[i];
        *line = (WadLine){.flags = u16(p + 4), .special = u16(p + 6), .tag = u16(p + 8)};
        for (int k = 0; k < 2; k++) {
            line->v[k] = u16(p + 2 * k);
            int side = u16(p + 10 + 2 * k);
            if (line->v[k] >= map->vertex_count)
                return fail_record(r, "linedef", i, "vertex", line->v[k], "0 to", map->vertex_count - 1);
            if (side != NONE && side >= map->side_count)
                return fail_record(r, "linedef", i, "sidedef", side, "65535 for none, or 0 to",
                                   map->side_count - 1);
            line->side[k] = side == NONE ? -1 : side;
            line->sector[k] = side == NONE ? -1 : map->sides[side].sector;
        }
    }
    return true;
}

static bool read_things(Reader *r) {
    Lump lump;
    if (!find_lump(r, "THINGS", THING, &lump)) return false;
    WadMap *map = r->map;
    map->thing_count = lump.count;
    map->things = ARENA_ARRAY(r->arena, WadThing, lump.count);
    for (int i = 0; i < lump.count; i++) {
        const unsigned char *p = lump.data + (size_t)i * THING;
        map->things[i] = (WadThing){{i16(p), i16(p + 2), 1}, i16(p + 4), u16(p + 6)};
    }
    return true;
}

static bool refuse_other_formats(const Reader *r) {
    const Directory *d = &r->directory;
    if (lump_is(d, r->marker + 1, "TEXTMAP")) {
        return error_set(r->error,
                         "%s: %s is a UDMF map, which is text (allowed: maps in the classic binary format)",
                         d->path, r->name);
    }
    for (int i = r->marker + 1; i < d->count && i <= r->marker + 11 && !is_map(d, i); i++) {
        if (!lump_is(d, i, "BEHAVIOR")) continue;
        return error_set(
            r->error,
            "%s: %s is a map in Hexen's format: it has a lump BEHAVIOR, and its LINEDEFS of 16 bytes "
            "name doors by scripts (allowed: maps in the classic binary format)",
            d->path, r->name);
    }
    return true;
}

bool wad_read_map(const char *path, Bytes content, const char *name, Arena *arena, WadMap *out,
                  Error *error) {
    Reader r = {.arena = arena, .error = error, .map = out};
    if (!open_directory(path, content, &r.directory, error)) return false;
    r.marker = find_map(&r.directory, name);
    if (r.marker < 0) return no_such_map(&r.directory, name ? name : "", error);
    char found[NAME + 1];
    lump_name(&r.directory, r.marker, found);
    r.name = arena_string(arena, found);
    *out = (WadMap){.path = path,
                    .name = r.name,
                    .content = content,
                    .directory = r.directory.entries,
                    .lump_count = r.directory.count};
    return refuse_other_formats(&r) && read_vertices(&r) && read_sectors(&r) && read_sides(&r) &&
           read_lines(&r) && read_things(&r);
}

bool wad_line_is_void(const WadMap *map, const WadLine *line) {
    WadPoint a = map->vertices[line->v[0]], b = map->vertices[line->v[1]];
    return (a.x == b.x && a.y == b.y) || line->sector[0] == line->sector[1];
}
