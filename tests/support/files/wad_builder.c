// wad_builder.c - see wad_builder.h.
#include "tests/support/files/wad_builder.h"

#include <string.h>

static unsigned char *put(Arena *arena, unsigned char **to, int *size, int *capacity, int bytes) {
    int first = *size;
    for (int i = 0; i < bytes; i++) *ARENA_PUSH(arena, *to, *size, *capacity) = 0;
    return *to + first;
}

static void put16(unsigned char *at, int value) {
    at[0] = (unsigned char)(value & 255);
    at[1] = (unsigned char)(value >> 8 & 255);
}

static void put32(unsigned char *at, long value) {
    put16(at, (int)(value & 0xFFFF));
    put16(at + 2, (int)(value >> 16 & 0xFFFF));
}

int wad_vertex(WadMaker *w, int x, int y) {
    unsigned char *at = put(w->arena, &w->vertices, &w->vertex_size, &w->vertex_capacity, 4);
    put16(at, x);
    put16(at + 2, y);
    return w->vertex_size / 4 - 1;
}

int wad_sector(WadMaker *w, int floor, int ceiling, const char *ceiling_flat, int tag) {
    unsigned char *at = put(w->arena, &w->sectors, &w->sector_size, &w->sector_capacity, 26);
    put16(at, floor);
    put16(at + 2, ceiling);
    memcpy(at + 4, "FLAT", 4);
    memcpy(at + 12, ceiling_flat, strlen(ceiling_flat));
    put16(at + 20, 160);
    put16(at + 24, tag);
    return w->sector_size / 26 - 1;
}

static int add_side(WadMaker *w, int sector) {
    if (sector < 0) return 0xFFFF;
    unsigned char *at = put(w->arena, &w->sides, &w->side_size, &w->side_capacity, 30);
    memcpy(at + 4, "UPPER", 5);
    memcpy(at + 12, "LOWER", 5);
    memcpy(at + 20, "MIDDLE", 6);
    put16(at + 28, sector);
    return w->side_size / 30 - 1;
}

int wad_line(WadMaker *w, int x1, int y1, int x2, int y2, int front, int back, int special, int tag) {
    int v1 = wad_vertex(w, x1, y1), v2 = wad_vertex(w, x2, y2);
    int right = add_side(w, front), left = add_side(w, back);
    unsigned char *at = put(w->arena, &w->lines, &w->line_size, &w->line_capacity, 14);
    int numbers[7] = {v1, v2, back >= 0 ? 4 : 1, special, tag, right, left};
    for (int i = 0; i < 7; i++) put16(at + 2 * i, numbers[i]);
    return w->line_size / 14 - 1;
}

void wad_thing(WadMaker *w, int x, int y, int angle, int type) {
    unsigned char *at = put(w->arena, &w->things, &w->thing_size, &w->thing_capacity, 10);
    int numbers[5] = {x, y, angle, type, 7};
    for (int i = 0; i < 5; i++) put16(at + 2 * i, numbers[i]);
}

typedef struct Wall {
    int x1, y1, x2, y2, front, back, special, tag;
} Wall;

void wad_two_rooms(WadMaker *w) {
    enum { PUSH = 1, SWITCH = 62, TAG = 5 };
    static const Wall WALLS[] = {
        {0, 0, 0, 256, WAD_ROOM, -1, 0, 0},
        {0, 256, 256, 256, WAD_ROOM, -1, 0, 0},
        {256, 256, 256, 160, WAD_ROOM, -1, 0, 0},
        {256, 160, 256, 96, WAD_ROOM, WAD_DOOR_SECTOR, PUSH, 0},
        {256, 96, 256, 0, WAD_ROOM, -1, 0, 0},
        {256, 0, 0, 0, WAD_ROOM, -1, 0, 0},
        {133, 97, 171, 120, WAD_ROOM, -1, 0, 0},
        {171, 120, 140, 170, WAD_ROOM, -1, 0, 0},
        {140, 170, 100, 131, WAD_ROOM, -1, 0, 0},
        {100, 131, 133, 97, WAD_ROOM, -1, 0, 0},
        {256, 160, 272, 160, WAD_DOOR_SECTOR, -1, 0, 0},
        {272, 96, 256, 96, WAD_DOOR_SECTOR, -1, 0, 0},
        {272, 0, 272, 96, WAD_HALL, -1, 0, 0},
        {272, 96, 272, 160, WAD_HALL, WAD_DOOR_SECTOR, PUSH, 0},
        {272, 160, 272, 256, WAD_HALL, -1, 0, 0},
        {272, 256, 528, 256, WAD_HALL, -1, 0, 0},
        {528, 256, 528, 160, WAD_HALL, -1, 0, 0},
        {528, 160, 528, 96, WAD_HALL, WAD_LIFT_SECTOR, SWITCH, TAG},
        {528, 96, 528, 0, WAD_HALL, -1, 0, 0},
        {528, 0, 272, 0, WAD_HALL, -1, 0, 0},
        {528, 160, 592, 160, WAD_LIFT_SECTOR, -1, 0, 0},
        {592, 96, 528, 96, WAD_LIFT_SECTOR, -1, 0, 0},
        {592, 0, 592, 96, WAD_COURT, -1, 0, 0},
        {592, 96, 592, 160, WAD_COURT, WAD_LIFT_SECTOR, 0, 0},
        {592, 160, 592, 256, WAD_COURT, -1, 0, 0},
        {592, 256, 848, 256, WAD_COURT, -1, 0, 0},
        {848, 256, 848, 0, WAD_COURT, -1, 0, 0},
        {848, 0, 592, 0, WAD_COURT, -1, 0, 0},
    };
    wad_sector(w, 0, 128, "CEIL", 0);
    wad_sector(w, 0, 0, "CEIL", 0);
    wad_sector(w, 0, 160, "CEIL", 0);
    wad_sector(w, 64, 160, "CEIL", TAG);
    wad_sector(w, 64, 256, "F_SKY1", 0);
    for (size_t i = 0; i < sizeof WALLS / sizeof *WALLS; i++) {
        const Wall *l = &WALLS[i];
        wad_line(w, l->x1, l->y1, l->x2, l->y2, l->front, l->back, l->special, l->tag);
    }
    wad_thing(w, 40, 128, 0, 1);
    wad_thing(w, 720, 128, 180, 11);
}

// ---- files

typedef struct Output {
    Arena *arena;
    unsigned char *data, *entries;
    int size, capacity, entry_size, entry_capacity;
} Output;

static void add_lump(Output *o, const char *name, const unsigned char *data, int size) {
    unsigned char *entry = put(o->arena, &o->entries, &o->entry_size, &o->entry_capacity, 16);
    put32(entry, o->size);
    put32(entry + 4, size);
    memcpy(entry + 8, name, strlen(name) < 8 ? strlen(name) : 8);
    if (size > 0) memcpy(put(o->arena, &o->data, &o->size, &o->capacity, size), data, (size_t)size);
}

static Bytes finish_file(Output *o) {
    int directory = o->size;
    memcpy(put(o->arena, &o->data, &o->size, &o->capacity, o->entry_size), o->entries, (size_t)o->entry_size);
    put32(o->data + 4, o->entry_size / 16);
    put32(o->data + 8, directory);
    // A byte more, which is not counted: see Bytes.
    put(o->arena, &o->data, &o->size, &o->capacity, 1);
    return (Bytes){o->data, (size_t)o->size - 1};
}

Bytes wad_file(const WadMaker *maps, const char *const *names, int count, const char *with) {
    Output o = {.arena = maps->arena};
    memcpy(put(o.arena, &o.data, &o.size, &o.capacity, 12), "PWAD", 4);
    for (int i = 0; i < count; i++) {
        const WadMaker *w = &maps[i];
        add_lump(&o, names[i], NULL, 0);
        add_lump(&o, "THINGS", w->things, w->thing_size);
        add_lump(&o, "LINEDEFS", w->lines, w->line_size);
        add_lump(&o, "SIDEDEFS", w->sides, w->side_size);
        add_lump(&o, "VERTEXES", w->vertices, w->vertex_size);
        add_lump(&o, "SECTORS", w->sectors, w->sector_size);
    }
    if (with) add_lump(&o, with, NULL, 0);
    return finish_file(&o);
}

static long get32(const unsigned char *at) { return at[0] | at[1] << 8 | at[2] << 16 | (long)at[3] << 24; }

long wad_lump(Bytes file, const char *name, long *size) {
    char padded[9] = "";
    strncpy(padded, name, 8);
    const unsigned char *entry = file.data + get32(file.data + 8);
    for (long i = 0; i < get32(file.data + 4); i++, entry += 16) {
        if (memcmp(entry + 8, padded, 8) != 0) continue;
        if (size) *size = get32(entry + 4);
        return get32(entry);
    }
    return -1;
}

// ---- pictures

enum { PATCH_WIDTH = 32, PATCH_HEIGHT = 128, FLAT_SIDE = 64 };

static void add_patch(Output *o) {
    enum { COLUMN = 3 + PATCH_HEIGHT + 2 };
    unsigned char lump[8 + 4 * PATCH_WIDTH + PATCH_WIDTH * COLUMN] = {0};
    put16(lump, PATCH_WIDTH);
    put16(lump + 2, PATCH_HEIGHT);
    for (int x = 0; x < PATCH_WIDTH; x++) {
        int at = 8 + 4 * PATCH_WIDTH + x * COLUMN;
        put32(lump + 8 + 4 * x, at);
        lump[at + 1] = PATCH_HEIGHT;
        for (int y = 0; y < PATCH_HEIGHT; y++) lump[at + 3 + y] = (unsigned char)(x + y);
        lump[at + COLUMN - 1] = 255;
    }
    add_lump(o, "PATCH", lump, sizeof lump);
}

static void add_walls(Output *o) {
    static const struct {
        const char *name;
        int width, height, patches;
    } WALLS[] = {{"MIDDLE", 64, 96, 2}, {"LOWER", 64, 64, 1}, {"UPPER", 64, 72, 1}, {"SKY1", 256, 128, 8}};
    enum { COUNT = sizeof WALLS / sizeof *WALLS };
    unsigned char lump[1024] = {0};
    int at = 4 + 4 * COUNT;
    put32(lump, COUNT);
    for (int i = 0; i < COUNT; i++) {
        put32(lump + 4 + 4 * i, at);
        memcpy(lump + at, WALLS[i].name, strlen(WALLS[i].name));
        put16(lump + at + 12, WALLS[i].width);
        put16(lump + at + 14, WALLS[i].height);
        put16(lump + at + 20, WALLS[i].patches);
        for (int p = 0; p < WALLS[i].patches; p++) put16(lump + at + 22 + 10 * p, PATCH_WIDTH * p);
        at += 22 + 10 * WALLS[i].patches;
    }
    add_lump(o, "TEXTURE1", lump, at);
}

Bytes wad_with_pictures(Arena *arena, Bytes file) {
    Output o = {.arena = arena};
    memcpy(put(arena, &o.data, &o.size, &o.capacity, 12), "IWAD", 4);
    const unsigned char *entry = file.data + get32(file.data + 8);
    for (long i = 0; i < get32(file.data + 4); i++, entry += 16) {
        char name[9] = "";
        memcpy(name, entry + 8, 8);
        add_lump(&o, name, file.data + get32(entry), (int)get32(entry + 4));
    }
    unsigned char palette[768], flat[FLAT_SIDE * FLAT_SIDE];
    for (int i = 0; i < 256; i++)
        palette[3 * i] = (unsigned char)i, palette[3 * i + 1] = (unsigned char)(255 - i),
                    palette[3 * i + 2] = (unsigned char)(i / 2);
    for (int i = 0; i < FLAT_SIDE * FLAT_SIDE; i++)
        flat[i] = (unsigned char)(i % FLAT_SIDE + 2 * (i / FLAT_SIDE));
    add_lump(&o, "PLAYPAL", palette, sizeof palette);
    add_lump(&o, "F_START", NULL, 0);
    add_lump(&o, "FLAT", flat, sizeof flat);
    add_lump(&o, "CEIL", flat, sizeof flat);
    add_lump(&o, "F_END", NULL, 0);
    add_lump(&o, "PNAMES", (const unsigned char *)"\1\0\0\0PATCH\0\0\0", 12);
    add_walls(&o);
    add_patch(&o);
    return finish_file(&o);
}

Bytes wad_spoilt(Arena *arena, const unsigned char *data, size_t size) {
    static const char *const NAMES[] = {"MAP01"};
    WadMaker maker = {.arena = arena};
    wad_two_rooms(&maker);
    Bytes file = wad_with_pictures(arena, wad_file(&maker, NAMES, 1, NULL));
    for (size_t i = 0; i + 4 <= size; i += 4) {
        size_t at = (size_t)(data[i] | data[i + 1] << 8) % (file.size - 1);
        memcpy(file.data + at, data + i + 2, 2);
    }
    return file;
}
