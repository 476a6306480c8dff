// test_sh3d_input.c - Sweet Home 3D files that are faulty, damaged or hostile, and real homes.
#include <criterion/criterion.h>
#include <stdio.h>
#include <string.h>
#include <zip.h>

#include "engine/core/random.h"
#include "maps/maps.h"
#include "tests/support/files/home_fixture.h"

extern const MapsReader MAPS_READER_SH3D;

// ---- bad input

// Each fault is named with its line, what was found and what is allowed.
Test(sh3d, names_faults) {
    static const struct {
        const char *xml, *says;
    } CASES[] = {
        {"", "empty"},
        {"<wall id='a' xStart='0' yStart='0' xEnd='4' thickness='1'/>",
         "Home.xml:3: wall has no attribute yEnd"},
        {"\n<wall id='a' xStart='NaN' yStart='0' xEnd='4' yEnd='0' thickness='1'/>",
         "Home.xml:4: wall has xStart='NaN'"},
        {"<wall id='a' xStart='1e30' yStart='0' xEnd='4' yEnd='0' thickness='1'/>", "is allowed"},
        {"<wall id='a' xStart='inf' yStart='0' xEnd='4' yEnd='0' thickness='1'/>", "xStart='inf'"},
        {"<wall id='a' xStart='1 2' yStart='0' xEnd='4' yEnd='0' thickness='1'/>", "xStart='1 2'"},
        {"<wall id='a' xStart='' yStart='0' xEnd='4' yEnd='0' thickness='1'/>", "xStart=''"},
        {"<wall id='a' xStart='0' yStart='0' xEnd='4' yEnd='0' thickness='-1'/>", "thickness='-1'"},
        {"<wall id='a' xStart='0' yStart='0' xEnd='4' yEnd='0' thickness='1' arcExtent='7'/>",
         "arcExtent='7'"},
        {"<wall id='a' level='x' xStart='0' yStart='0' xEnd='4' yEnd='0' thickness='1'/>",
         "level 'x', which the file does not have"},
        {"<wall id='a' xStart='0' yStart='0' xEnd='4' yEnd='0' thickness='1'/>\n"
         "<wall id='a' xStart='0' yStart='9' xEnd='4' yEnd='9' thickness='1'/>",
         "Home.xml:4: wall has the id 'a' of the wall in line 3"},
        {"<level id='l' elevation='0' height='250'/><level id='l' elevation='9' height='250'/>",
         "has the id 'l' of the level"},
        {"<level elevation='0' height='250'/>", "no attribute id"},
        {"<level id='l' elevation='0' height='0'/>", "height='0'"},
        {"<room floorColor='red'><point x='0' y='0'/><point x='1' y='0'/><point x='0' y='1'/></room>",
         "floorColor='red'"},
        {"<room><point x='0' y='0'/><point x='1'/><point x='0' y='1'/></room>", "point has no attribute y"},
        {HOME_ROOM "<pieceOfFurniture x='0' y='0' width='1' depth='1'/>", "no attribute height"},
        {HOME_ROOM "<pieceOfFurniture x='0' y='0' width='1' depth='1' height='1' modelRotation='1 2'/>",
         "modelRotation"},
        {HOME_ROOM "<light x='0' y='0' width='1' depth='1' height='1' power='-1'/>", "power='-1'"},
        {HOME_ROOM "<doorOrWindow x='0' y='0' width='1e9' depth='1' height='1'/>", "width='1e9'"},
        {HOME_ROOM "<observerCamera attribute='observerCamera' x='0' y='0' yaw='0' pitch='0'/>",
         "no attribute z"},
        {"<room><point/></room></home><home>", "Home.xml:3: not well-formed"},
        {"<a><b></a>", "Home.xml:3: not well-formed"},
    };
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Home h = home_of("%s", CASES[i].xml);
        cr_assert_not(h.good, "case %zu is read", i);
        cr_assert(strstr(h.error.text, CASES[i].says), "case %zu: %s", i, h.error.text);
        home_free(&h);
    }
    static const char BOMB[] =
        "<!DOCTYPE home [<!ENTITY a 'aaaaaaaa'><!ENTITY b '&a;&a;&a;&a;'>]><home name='&b;'/>";
    Home h = home_of_bytes((Bytes){(unsigned char *)BOMB, sizeof BOMB - 1}, NULL);
    cr_assert(!h.good && strstr(h.error.text, "document type"), "%s", h.error.text);
    home_free(&h);
    static const char OTHER[] = "<kml/>";
    h = home_of_bytes((Bytes){(unsigned char *)OTHER, sizeof OTHER - 1}, NULL);
    cr_assert(!h.good && strstr(h.error.text, "home is needed"), "%s", h.error.text);
    home_free(&h);
}

// Groups nested without end do not exhaust the stack.
Test(sh3d, refuses_deep_nesting) {
    static char xml[1 << 20] = "<home>";
    size_t used = strlen(xml);
    for (int i = 0; i < 20000; i++)
        used += (size_t)snprintf(xml + used, sizeof xml - used, "<furnitureGroup>");
    Home h = home_of_bytes((Bytes){(unsigned char *)xml, used}, NULL);
    cr_assert(!h.good && strstr(h.error.text, "nested too deep"), "%s", h.error.text);
    home_free(&h);
}

static bool read_file(Arena *arena, const char *path, Bytes content, Error *error) {
    Building b = {0};
    return MAPS_READER_SH3D.read(path, content, arena, &b, error);
}

// A ZIP that unpacks to far more than it holds, one whose Home is no stream of objects, one without a home, one that
// is none, and a home without anything: one sentence each.
Test(sh3d, refuses_bad_archives) {
    Arena arena = {0};
    Error error;
    size_t size = (size_t)65 << 20;
    char *zeros = arena_alloc(&arena, size, 1);
    Bytes bomb = home_zip(&arena, &(HomeEntry){"Home.xml", zeros, size}, 1);
    cr_assert_lt(bomb.size, (size_t)1 << 20);
    cr_assert_not(read_file(&arena, "bomb.sh3d", bomb, &error));
    cr_assert(strstr(error.text, "bomb.sh3d: entry Home.xml unpacks to"), "%s", error.text);
    bomb = home_zip(&arena, &(HomeEntry){"Home.xml", zeros, size / 2}, 1);
    cr_assert_not(read_file(&arena, "bomb.sh3d", bomb, &error));
    cr_assert(strstr(error.text, "at most 200 times"), "%s", error.text);
    Bytes old = home_zip(&arena, &(HomeEntry){"Home", "xx", 2}, 1);
    cr_assert_not(read_file(&arena, "old.sh3d", old, &error));
    cr_assert(strstr(error.text, "old.sh3d:Home: the entry is no stream of Java objects"), "%s", error.text);
    Bytes other = home_zip(&arena, &(HomeEntry){"readme", "xx", 2}, 1);
    cr_assert_not(read_file(&arena, "other.sh3d", other, &error));
    cr_assert(strstr(error.text, "other.sh3d: the archive is no home"), "%s", error.text);
    cr_assert_not(read_file(&arena, "none.sh3d", (Bytes){(unsigned char *)"plain text", 10}, &error));
    cr_assert(strstr(error.text, "not a usable ZIP"), "%s", error.text);
    cr_assert_not(read_file(&arena, "none.sh3d", (Bytes){(unsigned char *)"", 0}, &error));
    cr_assert_not(read_file(&arena, "Home.xml", (Bytes){(unsigned char *)"", 0}, &error));
    cr_assert(strstr(error.text, "Home.xml:1: not well-formed"), "%s", error.text);
    Bytes empty = home_zip(&arena, &(HomeEntry){"Home.xml", "<home/>", 7}, 1);
    cr_assert_not(read_file(&arena, "empty.sh3d", empty, &error));
    cr_assert(strstr(error.text, "the home is empty"), "%s", error.text);
    arena_free(&arena);
}

// Proves that all entries together are limited, each time one is read: 1 GiB in 32 readings, and not a byte more; a missing entry and
// one beyond the caller's limit cost nothing. Stored, not packed: the test is to take no longer than copying.
Test(sh3d, limits_what_is_unpacked_in_all) {
    enum { SIZE = 32 << 20 };
    Arena arena = {0}, scratch = {0};
    Error error;
    Archive *archive;
    Bytes out;
    unsigned char *large = arena_alloc(&arena, SIZE, 1);
    for (int i = 0; i < SIZE; i += 4096) large[i] = (unsigned char)(i / 4096 * 7);
    zip_error_t reason;
    zip_source_t *store = zip_source_buffer_create(NULL, 0, 0, &reason);
    zip_source_keep(store);
    zip_t *zip = zip_open_from_source(store, ZIP_TRUNCATE, &reason);
    zip_int64_t index = zip_file_add(zip, "large", zip_source_buffer(zip, large, SIZE, 0), 0);
    cr_assert_eq(zip_set_file_compression(zip, (zip_uint64_t)index, ZIP_CM_STORE, 0), 0);
    cr_assert(zip_file_add(zip, "small", zip_source_buffer(zip, "x", 1, 0), 0) >= 0);
    cr_assert_eq(zip_close(zip), 0);
    zip_stat_t stat;
    zip_source_stat(store, &stat);
    Bytes content = {arena_alloc(&arena, stat.size, 1), stat.size};
    zip_source_open(store);
    cr_assert_eq(zip_source_read(store, content.data, content.size), (zip_int64_t)content.size);
    zip_source_close(store);
    zip_source_free(store);
    cr_assert(archive_open(content, "all.zip", &arena, &archive, &error), "%s", error.text);
    for (size_t read = 0; read < ARCHIVE_MAX_TOTAL; read += SIZE) {
        arena_reset(&scratch);
        cr_assert_not(archive_read(archive, "absent", SIZE, &scratch, &out, &error));
        cr_assert_not(archive_read(archive, "large", SIZE - 1, &scratch, &out, &error));
        cr_assert(strstr(error.text,
                         "all.zip: entry large unpacks to 33554432 bytes (at most 33554431 are allowed)"),
                  "%s", error.text);
        cr_assert(archive_read(archive, "large", SIZE, &scratch, &out, &error), "%s", error.text);
        cr_assert(out.size == SIZE && memcmp(out.data, large, SIZE) == 0);
    }
    cr_assert_not(archive_read(archive, "small", SIZE, &scratch, &out, &error));
    cr_assert(strstr(error.text, "all.zip: its entries unpack to more than 1073741824 bytes"), "%s",
              error.text);
    archive_close(archive);
    arena_free(&scratch);
    arena_free(&arena);
}

// Proves that no entry comes out other than it went in, packed or stored: with any byte of its data changed it is refused, and so it is
// where the directory says fewer bytes than there are, or more.
Test(sh3d, refuses_entries_that_changed) {
    Arena arena = {0};
    Error error;
    Bytes out;
    unsigned char noise[200], text[4000];
    Random random = {3};
    for (size_t i = 0; i < sizeof noise; i++) noise[i] = (unsigned char)random_index(&random, 256);
    for (size_t i = 0; i < sizeof text; i++)
        text[i] = (unsigned char)('a' + i % 7 + (size_t)random_index(&random, 2));
    const HomeEntry ENTRIES[] = {{"stored", noise, sizeof noise}, {"packed", text, sizeof text}};
    for (int k = 0; k < 2; k++) {
        Bytes good = home_zip(&arena, &ENTRIES[k], 1);
        // The local header is 30 bytes and the name, then comes the data; the directory's sizes are 20 and 24 bytes into it.
        size_t from = 30 + 6, directory = from;
        while (memcmp(good.data + directory, "PK\1\2", 4) != 0) directory++;
        for (size_t at = from; at <= directory + 1; at++) {
            Bytes bad = {arena_alloc(&arena, good.size, 1), good.size};
            memcpy(bad.data, good.data, good.size);
            if (at < directory)
                bad.data[at] ^= (unsigned char)(1 << random_index(&random, 8));
            else
                for (size_t field = 20; field <= 24; field += 4)
                    if (k == 0 || field == 24) bad.data[directory + field] += at == directory ? 1 : 255;
            Archive *archive;
            if (!archive_open(bad, "changed.zip", &arena, &archive, &error)) continue;
            bool read = archive_read(archive, ENTRIES[k].name, 1 << 20, &arena, &out, &error);
            cr_assert(!read ||
                          (out.size == ENTRIES[k].size && memcmp(out.data, ENTRIES[k].data, out.size) == 0),
                      "entry %s, byte %zu: %zu bytes come out", ENTRIES[k].name, at - from, out.size);
            cr_assert(read || strstr(error.text, "changed.zip: "), "%s", error.text);
            archive_close(archive);
        }
    }
    arena_free(&arena);
}
