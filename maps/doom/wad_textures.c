// wad_textures.c - the pictures of a WAD: flats of 64 x 64, and wall textures composed of patches, in the colours of its palette.
//
// Lumps (id Software 1993): PLAYPAL, whose first 256 colours count; flats between F_START and F_END; PNAMES and TEXTURE1, TEXTURE2, which
// say where patches lie on a texture; a patch is columns of posts. Of two lumps of one name the last counts, of two textures the first. A
// WAD without a palette has no pictures here. Damaged pictures are left out and counted; where patches leave a texture open it is black.
#include <stdio.h>
#include <stdlib.h>

#include "maps/building/texture.h"
#include "maps/doom/wad.h"

enum { COLOURS = 256, FLAT = 64, NAME = 8, MOST_SIDE = 4096 };
// How many texels and posts may be composed in all: the largest WADs have some 10 million.
static const double MOST_WORK = 1e8;

typedef struct Entry {
    char name[NAME + 1];
    bool flat;
    int lump;
} Entry;

// A texture's definition, and whether it was made already.
typedef struct Made {
    char name[NAME + 1];
    bool flat;
    int texture, width, height;
} Made;

struct WadPictures {
    const WadMap *map;
    Arena *arena, *scratch;
    Building *b;
    Bytes palette, patch_names, definitions[2];
    Entry *entries;  // sorted by name; of each name and kind the last
    int entry_count;
    Made *made;
    int made_count, made_capacity;
    double work;  // left
    NoteTally missing;
};

static int u16(const unsigned char *p) { return p[0] | p[1] << 8; }
static int i16(const unsigned char *p) { return (int16_t)u16(p); }
static uint32_t u32(const unsigned char *p) { return (uint32_t)u16(p) | (uint32_t)u16(p + 2) << 16; }

static int lump_order(const void *p, const void *q) {
    const Entry *a = p, *b = q;
    int order = strcmp(a->name, b->name);
    return order ? order : a->flat != b->flat ? a->flat - b->flat : (a->lump > b->lump) - (a->lump < b->lump);
}

// The last lump of the name; no data without.
static Bytes find_lump(const WadPictures *w, const char *name, bool flat) {
    int low = 0, high = w->entry_count;
    Entry key = {.flat = flat, .lump = w->map->lump_count};
    snprintf(key.name, sizeof key.name, "%s", name);
    while (low < high) {
        int middle = (low + high) / 2;
        if (lump_order(&w->entries[middle], &key) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == 0) return (Bytes){0};
    const Entry *e = &w->entries[low - 1];
    char ignored[NAME + 1];
    if (e->flat != flat || strcmp(e->name, name) != 0) return (Bytes){0};
    return wad_lump_bytes(w->map, e->lump, ignored);
}

static bool ends_in(const char *name, const char *end) {
    size_t length = strlen(name), tail = strlen(end);
    return length >= tail && length <= tail + 1 && strcmp(name + length - tail, end) == 0;
}

static void list_lumps(WadPictures *w) {
    const WadMap *map = w->map;
    w->entries = ARENA_ARRAY(w->scratch, Entry, map->lump_count + 1);
    bool flats = false;
    for (int i = 0; i < map->lump_count; i++) {
        Entry *e = &w->entries[w->entry_count];
        Bytes data = wad_lump_bytes(map, i, e->name);
        // F_START, and FF_START of added ones; F1_START within does no harm.
        if (ends_in(e->name, "F_START")) flats = true;
        if (ends_in(e->name, "F_END")) flats = false;
        if (!data.data) continue;
        e->flat = flats;
        e->lump = i;
        w->entry_count++;
    }
    qsort(w->entries, (size_t)w->entry_count, sizeof *w->entries, lump_order);
}

WadPictures *wad_open_pictures(const WadMap *map, Arena *arena, Arena *scratch, Building *b) {
    WadPictures *w = ARENA_ARRAY(scratch, WadPictures, 1);
    *w = (WadPictures){.map = map, .arena = arena, .scratch = scratch, .b = b, .work = MOST_WORK};
    list_lumps(w);
    w->palette = find_lump(w, "PLAYPAL", false);
    w->patch_names = find_lump(w, "PNAMES", false);
    w->definitions[0] = find_lump(w, "TEXTURE1", false);
    w->definitions[1] = find_lump(w, "TEXTURE2", false);
    if (w->palette.size < 3 * COLOURS) w->palette.data = NULL;
    return w;
}

static void set_texel(const WadPictures *w, int colour, uint8_t *texel) {
    memcpy(texel, w->palette.data + 3 * colour, 3);
    texel[3] = 255;
}

static uint8_t *make_flat(WadPictures *w, const char *name, int *width, int *height) {
    Bytes lump = find_lump(w, name, true);
    if (!lump.data || lump.size < FLAT * FLAT) return NULL;
    uint8_t *texels = ARENA_ARRAY(w->scratch, uint8_t, 4 * FLAT * FLAT);
    for (int i = 0; i < FLAT * FLAT; i++) set_texel(w, lump.data[i], texels + 4 * i);
    *width = *height = FLAT;
    return texels;
}

// A column of a patch: posts of a height over its top, a length, a byte, as many colours and a byte; 255 ends it. Posts that do not
// go down begin that far below the last one, which patches taller than 254 need.
static void draw_column(WadPictures *w, Bytes patch, size_t at, int x, int y, int width, int height,
                        uint8_t *texels) {
    int top = -1;
    while (at + 3 < patch.size && patch.data[at] != 255 && w->work > 0) {
        int down = patch.data[at], length = patch.data[at + 1];
        top = down <= top ? top + down : down;
        w->work -= 1 + length;
        for (int i = 0; i < length && at + 3 + (size_t)i < patch.size; i++) {
            int row = y + top + i;
            if (row >= 0 && row < height)
                set_texel(w, patch.data[at + 3 + (size_t)i],
                          texels + 4 * ((size_t)row * (size_t)width + (size_t)x));
        }
        at += 4 + (size_t)length;
    }
}

static void draw_patch(WadPictures *w, Bytes patch, int x, int y, int width, int height, uint8_t *texels) {
    enum { HEADER = 8 };
    if (!patch.data || patch.size < HEADER) return;
    int columns = u16(patch.data);
    for (int i = 0; i < columns && HEADER + 4 * (size_t)(i + 1) <= patch.size && w->work > 0; i++) {
        w->work -= 1;
        if (x + i < 0 || x + i >= width) continue;
        draw_column(w, patch, u32(patch.data + HEADER + 4 * (size_t)i), x + i, y, width, height, texels);
    }
}

// The definition of a texture, its first byte; NULL without.
static const unsigned char *find_definition(const WadPictures *w, const char *name) {
    enum { DEFINITION = 22, PATCH = 10 };
    for (int t = 0; t < 2; t++) {
        Bytes lump = w->definitions[t];
        uint32_t count = lump.data && lump.size >= 4 ? u32(lump.data) : 0;
        for (uint32_t i = 0; i < count && 4 * ((size_t)i + 2) <= lump.size; i++) {
            size_t at = u32(lump.data + 4 * ((size_t)i + 1));
            char found[NAME + 1];
            if (at > lump.size || lump.size - at < DEFINITION) continue;
            wad_name(lump.data + at, found);
            if (strcmp(found, name) != 0) continue;
            size_t patches = (size_t)u16(lump.data + at + 20);
            return patches * PATCH <= lump.size - at - DEFINITION ? lump.data + at : NULL;
        }
    }
    return NULL;
}

static uint8_t *make_wall(WadPictures *w, const char *name, int *width, int *height) {
    const unsigned char *d = find_definition(w, name);
    if (!d) return NULL;
    *width = u16(d + 12), *height = u16(d + 14);
    if (*width < 1 || *height < 1 || *width > MOST_SIDE || *height > MOST_SIDE) return NULL;
    double size = (double)*width * *height;
    if (size > w->work) return NULL;
    w->work -= size;
    uint8_t *texels = ARENA_ARRAY(w->scratch, uint8_t, 4 * (size_t)*width * (size_t)*height);
    for (size_t i = 0; i < (size_t)*width * (size_t)*height; i++) texels[4 * i + 3] = 255;
    int patches = u16(d + 20);
    for (int i = 0; i < patches && w->work > 0; i++) {
        const unsigned char *p = d + 22 + 10 * i;
        size_t number = (size_t)u16(p + 4);
        if (w->patch_names.size < 4 + NAME * (number + 1)) continue;
        char patch[NAME + 1];
        wad_name(w->patch_names.data + 4 + NAME * number, patch);
        draw_patch(w, find_lump(w, patch, false), i16(p), i16(p + 2), *width, *height, texels);
    }
    return texels;
}

int wad_texture(WadPictures *w, const char *name, bool flat, int *width, int *height) {
    bool none = !w->palette.data || !*name || strcmp(name, "-") == 0;
    if (none) return 0;
    for (int i = 0; i < w->made_count; i++) {
        const Made *m = &w->made[i];
        if (m->flat != flat || strcmp(m->name, name) != 0) continue;
        *width = m->width, *height = m->height;
        return m->texture;
    }
    Made made = {.flat = flat};
    snprintf(made.name, sizeof made.name, "%s", name);
    uint8_t *texels =
        flat ? make_flat(w, name, &made.width, &made.height) : make_wall(w, name, &made.width, &made.height);
    if (texels) made.texture = texture_add_pixels(w->arena, w->b, name, made.width, made.height, texels);
    if (!made.texture) building_tally(&w->missing, name, vec3(0, 0, 0));
    *ARENA_PUSH(w->scratch, w->made, w->made_count, w->made_capacity) = made;
    *width = made.width, *height = made.height;
    return made.texture;
}

void wad_note_missing(WadPictures *w) {
    if (w->palette.data)
        building_note_tally(w->arena, w->b, w->map->path, &w->missing,
                            "textures are not in the file, or damaged, and have a colour of their own");
}
