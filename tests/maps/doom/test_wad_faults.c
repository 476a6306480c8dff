// test_wad_faults.c - damaged Doom maps, and files of several.
#include <criterion/criterion.h>

#include "maps/maps.h"
#include "tests/maps/doom/wad_fixture.h"
#include "tests/support/files/wad_builder.h"
#include "tests/support/support.h"

extern const MapsReader MAPS_READER_WAD;

// ---- faults

static bool refused(Arena *arena, Bytes file, const char *map, const char *expected) {
    Building b;
    Error error = {""};
    bool read = maps_read_map(wad_write_wad(arena, file), map, arena, &b, &error);
    cr_expect_not(read, "was read; expected: %s", expected);
    cr_expect(read || strstr(error.text, expected), "found: %s; expected: %s", error.text, expected);
    return !read;
}

static Bytes small_file(Arena *arena, const char *with) {
    static const char *const NAMES[] = {"MAP01"};
    WadMaker maker = {.arena = arena};
    wad_two_rooms(&maker);
    return wad_file(&maker, NAMES, 1, with);
}

static void set16(Bytes file, long at, int value) {
    file.data[at] = (unsigned char)(value & 255);
    file.data[at + 1] = (unsigned char)(value >> 8 & 255);
}

static void set32(Bytes file, long at, long value) {
    set16(file, at, (int)(value & 0xFFFF));
    set16(file, at + 2, (int)(value >> 16 & 0xFFFF));
}

// The place of the directory's entry with this name.
static long entry_of(Bytes file, const char *name) {
    char padded[9] = "";
    strncpy(padded, name, 8);
    long at = file.data[8] | file.data[9] << 8 | file.data[10] << 16;
    while (memcmp(file.data + at + 8, padded, 8) != 0) at += 16;
    return at;
}

// Proves that each fault of a file is refused with a sentence that says where and what.
Test(wad, faults_are_named) {
    static const struct {
        const char *lump;
        int at, value;  // 16 bits there
        const char *expected;
    } RECORDS[] = {
        {"LINEDEFS", 2, 60000, "linedef 0: vertex 60000 (allowed: 0 to 55)"},
        {"LINEDEFS", 14 + 10, 40000, "linedef 1: sidedef 40000 (allowed: 65535 for none, or 0 to 31)"},
        {"SIDEDEFS", 30 + 28, 5, "sidedef 1: sector 5 (allowed: 0 to 4)"},
    };
    static const struct {
        const char *lump;
        int at;
        long value;  // 32 bits there, in the directory's entry
        const char *expected;
    } ENTRIES[] = {
        {"VERTEXES", 0, 0x7FFFFFFF, "lump VERTEXES: 224 bytes at byte 2147483647 do not lie within the file"},
        {"SIDEDEFS", 4, 0x7FFFFFF0, "lump SIDEDEFS: 2147483632 bytes"},
        {"SECTORS", 4, -2147483647 - 1, "lump SECTORS: -2147483648 bytes"},
        {"LINEDEFS", 4, 15, "lump LINEDEFS: 15 bytes (allowed: up to 65535 records of 14 bytes each)"},
        {"THINGS", 8, 0x41414141, "none of its 6 lumps begins a map"},
        {"SECTORS", 8, 0x41414141, "MAP01 has no lump SECTORS"},
        {"THINGS", 4, 20, NULL},
    };
    Arena arena = {0};
    for (size_t i = 0; i < sizeof RECORDS / sizeof *RECORDS; i++) {
        Bytes file = small_file(&arena, NULL);
        set16(file, wad_lump(file, RECORDS[i].lump, NULL) + RECORDS[i].at, RECORDS[i].value);
        refused(&arena, file, NULL, RECORDS[i].expected);
    }
    for (size_t i = 0; i < sizeof ENTRIES / sizeof *ENTRIES; i++) {
        Bytes file = small_file(&arena, NULL);
        set32(file, entry_of(file, ENTRIES[i].lump) + ENTRIES[i].at, ENTRIES[i].value);
        if (ENTRIES[i].expected) refused(&arena, file, NULL, ENTRIES[i].expected);
    }
    refused(&arena, small_file(&arena, "BEHAVIOR"), NULL, "Hexen's format");
    Bytes file = small_file(&arena, NULL);
    memcpy(file.data + entry_of(file, "THINGS") + 8, "TEXTMAP", 8);
    refused(&arena, file, NULL, "UDMF");
    arena_free(&arena);
}

// Proves the same of headers that lie, and that a file cut off anywhere is refused or read, never more.
Test(wad, cut_and_lying_files) {
    Arena arena = {0};
    static const long COUNTS[] = {-1, 0x7FFFFFFF, 1000000}, PLACES[] = {-1, 0x7FFFFFFF, 0x7FFFFFF0};
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 2; k++) {
            Bytes file = small_file(&arena, NULL);
            set32(file, k ? 8 : 4, k ? PLACES[i] : COUNTS[i]);
            refused(&arena, file, NULL, "its directory of");
        }
    }
    Bytes whole = small_file(&arena, NULL);
    for (size_t size = 0; size < whole.size; size += 7) {
        Building b = {0};
        Error error = {""};
        Arena own = {0};
        bool read = MAPS_READER_WAD.read("cut.wad", (Bytes){whole.data, size}, &own, &b, &error);
        cr_expect(!read && error.text[0], "cut to %zu bytes: read %d, `%s`", size, read, error.text);
        arena_free(&own);
    }
    arena_free(&arena);
}

// Proves that a missing wall is noted with its sector and place while the rest opens, and that lines which bound nothing
// are counted.
Test(wad, open_sectors_are_noted) {
    Made m = {.arena = {0}};
    WadMaker maker = {.arena = &m.arena};
    wad_two_rooms(&maker);
    // The hall's southern wall now faces nothing on either side.
    unsigned char *line = maker.lines + 19 * 14;
    memset(line + 10, 0xFF, 4);
    wad_line(&maker, 50, 50, 50, 50, WAD_ROOM, -1, 0, 0);
    wad_line(&maker, 60, 60, 70, 60, WAD_ROOM, WAD_ROOM, 0, 0);
    wad_open_file(&m, wad_write_map(&m.arena, &maker));
    static const char *const EXPECTED[] = {"sector 2 is not closed near", "1 lines have no length",
                                           "1 lines have the same sector on both sides",
                                           "1 lines have no sides"};
    for (size_t i = 0; i < sizeof EXPECTED / sizeof *EXPECTED; i++) {
        bool found = false;
        for (int n = 0; n < m.building.note_count; n++)
            found = found || strstr(m.building.notes[n].text, EXPECTED[i]);
        cr_expect(found, "no note says: %s", EXPECTED[i]);
    }
    for (int s = 0; s < 5; s++) cr_expect(wad_region_of(&m.building, s), "sector %d", s);
    arena_free(&m.arena);
}

// Proves that two rooms with a wall between them that has no thickness open, and that it is told.
Test(wad, walls_without_thickness_are_noted) {
    static const int CORNERS[2][4][2] = {{{0, 0}, {0, 64}, {64, 64}, {64, 0}},
                                         {{64, 0}, {64, 64}, {128, 64}, {128, 0}}};
    Made m = {.arena = {0}};
    WadMaker maker = {.arena = &m.arena};
    for (int room = 0; room < 2; room++) {
        wad_sector(&maker, 0, 100, "CEIL", 0);
        for (int i = 0; i < 4; i++) {
            const int *a = CORNERS[room][i], *b = CORNERS[room][(i + 1) % 4];
            wad_line(&maker, a[0], a[1], b[0], b[1], room, -1, 0, 0);
        }
    }
    wad_open_file(&m, wad_write_map(&m.arena, &maker));
    cr_assert_eq(m.building.note_count, 1);
    cr_expect(strstr(m.building.notes[0].text, "1 walls have no thickness"), "%s", m.building.notes[0].text);
    cr_expect_eq(m.graph.portal_count, 1);
    // Without things one starts in the middle of the first region.
    cr_expect_float_eq(m.building.start.y, 32 * UNIT, 1e-12);
    arena_free(&m.arena);
}

// ---- several maps

// Proves that a map is found by its name, whatever its case, the first one without, that the hash tells them apart, and
// that an unknown name lists those there are.
Test(wad, maps_by_name) {
    Arena arena = {0};
    static const char *const NAMES[] = {"E1M1", "E1M2"};
    WadMaker makers[2] = {{.arena = &arena}, {.arena = &arena}};
    for (int i = 0; i < 2; i++) wad_two_rooms(&makers[i]);
    wad_thing(&makers[1], 30, 30, 90, 2);
    Bytes file = wad_file(makers, NAMES, 2, NULL);
    const char *path = wad_write_wad(&arena, file);
    Building first, second;
    Error error;
    cr_assert(maps_read(path, &arena, &first, &error), "%s", error.text);
    cr_assert(maps_read_map(path, "e1m2", &arena, &second, &error), "%s", error.text);
    cr_expect_str_eq(first.map, "E1M1");
    cr_expect_str_eq(second.map, "E1M2");
    cr_expect_eq(second.viewpoint_count, 3);
    cr_expect_neq(first.hash, second.hash);
    refused(&arena, file, "E2M1", "there is no map `E2M1` (allowed: E1M1, E1M2)");
    char *output;
    int code = support_run(&arena, &output, "%s/enfilade info '%s' --map E1M2 --json", support_build(), path);
    cr_expect_eq(code, 0, "%s", output);
    code = support_run(&arena, &output, "%s/enfilade info '%s' --map E9M9", support_build(), path);
    cr_expect(code == 1 && strstr(output, "allowed: E1M1, E1M2"), "%s", output);
    arena_free(&arena);
}

// Proves that a round hall of more corners than a region may have becomes several regions that are all of it. Tolerance: corners are
// whole millimetres, along 1,250 m of wall.
Test(wad, round_halls_are_parted) {
    enum { CORNERS = 100 };
    Made m = {.arena = {0}};
    WadMaker maker = {.arena = &m.arena};
    int x[CORNERS], y[CORNERS], sector = wad_sector(&maker, 0, 128, "FLAT", 0);
    double area = 0;
    for (int i = 0; i < CORNERS; i++) {
        double angle = -2 * M_PI * i / CORNERS;  // clockwise: the hall is to the right
        x[i] = (int)lrint(6400 * cos(angle));
        y[i] = (int)lrint(6400 * sin(angle));
    }
    for (int i = 0; i < CORNERS; i++) {
        int k = (i + 1) % CORNERS;
        wad_line(&maker, x[i], y[i], x[k], y[k], sector, -1, 0, 0);
        area += ((double)x[k] * y[i] - (double)x[i] * y[k]) / 2 * UNIT * UNIT;
    }
    wad_thing(&maker, 0, 0, 90, 1);
    wad_open_file(&m, wad_write_map(&m.arena, &maker));
    cr_expect_gt(m.building.region_count, 1);
    for (int i = 0; i < m.building.region_count; i++)
        cr_expect_leq(m.building.rings[m.building.regions[i].first_ring].point_count, 60);
    cr_expect_float_eq(wad_area_of_sector(&m.building, sector), area, 1250 * 0.001, "%g of %g m2",
                       wad_area_of_sector(&m.building, sector), area);
    arena_free(&m.arena);
}
