// test_sh3d_input.c - Sweet Home 3D files that are faulty, damaged or hostile, and real homes.
#include <criterion/criterion.h>
#include <stdio.h>
#include <string.h>
#include <zip.h>

#include "engine/core/random.h"
#include "maps/maps.h"
#include "tests/support/home_fixture.h"
#include "tests/support/support.h"

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

// A ZIP that unpacks to far more than it holds, one without Home.xml (which names the preference to set), one that
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
    cr_assert(strstr(error.text, "Save homes in XML format"), "%s", error.text);
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

// A home with a door, a model with its library, and a stair, as a small file to spoil.
static Bytes small_file(Arena *arena) {
    static const char XML[] =
        "<?xml version='1.0'?>\n<home version='7000' wallHeight='250'>\n<level id='l0' elevation='0' "
        "floorThickness='12' height='250'/>\n"
        "<level id='l1' elevation='262' floorThickness='12' height='250'/>\n"
        "<doorOrWindow level='l0' name='Door' x='200' y='0' width='90' depth='10' height='200' model='2' "
        "cutOutShape='M0,1 v-0.788 a0.5,0.2 0 1,1 "
        "1,0 v0.788 z'>" HOME_SASH_LEFT
        "</doorOrWindow>\n<pieceOfFurniture level='l0' name='w' model='1/w.obj' "
        "x='100' y='200' width='10' depth='40' "
        "height='20' angle='0.3' pitch='0.2'/>\n<light level='l0' x='50' y='50' width='10' depth='10' "
        "height='10' power='0.5'><lightSource "
        "x='0.5' y='0.5' z='0.5' color='FFFFFFFF'/></light>\n<pieceOfFurniture level='l0' name='Stair' "
        "x='300' y='150' width='80' depth='200' "
        "height='262' staircaseCutOutShape='M0,0 v1 h1 v-1 z'/>\n<wall id='a' level='l0' wallAtEnd='b' "
        "xStart='0' yStart='0' xEnd='400' yEnd='0' "
        "thickness='10' height='250'/>\n<wall id='b' level='l0' wallAtStart='a' xStart='400' yStart='0' "
        "xEnd='400' yEnd='300' thickness='10' "
        "height='100' heightAtEnd='250' arcExtent='0.5'/>\n" HOME_ROOM "</home>\n";
    HomeEntry entries[] = {{"Home.xml", XML, sizeof XML - 1},
                           {"1/w.obj", HOME_WEDGE, sizeof HOME_WEDGE - 1},
                           {"1/w.mtl", HOME_WEDGE_LIBRARY, sizeof HOME_WEDGE_LIBRARY - 1},
                           {"2", HOME_WEDGE, sizeof HOME_WEDGE - 1}};
    return home_zip(arena, entries, 4);
}

static bool read_named(Arena *arena, const char *folder, const char *name, Bytes content, Building *b,
                       Error *error) {
    const char *path = arena_format(arena, "%s/%s", folder, name);
    cr_assert(file_write(path, content.data, content.size, error), "%s", error->text);
    return maps_read(path, arena, b, error);
}

// The content decides where the suffix is wrong; the suffix decides who complains where the content is.
Test(sh3d, reader_is_chosen_by_suffix_and_content) {
    Arena arena = {0};
    Building b;
    Error error;
    const char *folder = support_folder(&arena);
    Bytes home = small_file(&arena), text = {(unsigned char *)"hello", 5};
    cr_assert(read_named(&arena, folder, "home.sh3d", home, &b, &error), "%s", error.text);
    cr_assert_eq(b.hash, file_hash(home.data, home.size, 0));
    cr_assert(strstr(b.source, "home.sh3d"));
    cr_assert_eq(b.opening_count, 1, "openings of the building are those of the sketch");
    cr_assert(read_named(&arena, folder, "home.xml", home, &b, &error), "%s", error.text);
    cr_assert(read_named(&arena, folder, "home.plan", home, &b, &error), "%s", error.text);
    cr_assert_not(read_named(&arena, folder, "text.SH3D", text, &b, &error));
    cr_assert(strstr(error.text, "not a usable ZIP"), "%s", error.text);
    cr_assert_not(read_named(&arena, folder, "text.txt", text, &b, &error));
    cr_assert(strstr(error.text, "known are .plan .sh3d .xml"), "%s", error.text);
    cr_assert_not(maps_read("/nowhere/at/all.sh3d", &arena, &b, &error));
    arena_free(&arena);
}

static void try_spoiled(const char *path, unsigned char *data, size_t size, const char *what, long which) {
    Arena arena = {0};
    Archive *archive = NULL;
    Building b = {0};
    Sketch sketch = {0};
    Error error = {""};
    Bytes content = {data, size}, xml = content;
    bool good = true;
    if (strstr(path, ".sh3d")) {
        good = archive_open(content, path, &arena, &archive, &error);
        good = good && archive_read(archive, "Home.xml", SH3D_MAX_XML, &arena, &xml, &error);
    }
    good = good && sh3d_sketch(xml, archive, path, &arena, &b, &sketch, &error);
    cr_assert(good || strlen(error.text) > 0, "%s, %s %ld: refused without a word", path, what, which);
    archive_close(archive);
    arena_free(&arena);
}

// Cuts and flips: a sentence or a usable plan, never a crash.
static void spoil(const char *path, Bytes content, size_t step, int flips, uint64_t seed) {
    Arena arena = {0};
    unsigned char *copy = arena_alloc(&arena, content.size + 1, 1);
    for (size_t cut = 0; cut < content.size; cut += step) {
        memcpy(copy, content.data, cut);
        copy[cut] = 0;
        try_spoiled(path, copy, cut, "cut at", (long)cut);
    }
    memcpy(copy, content.data, content.size);
    Random random = {seed};
    for (int i = 0; i < flips; i++) {
        int at = random_index(&random, (int)content.size), bit = random_index(&random, 8);
        copy[at] ^= (unsigned char)(1 << bit);
        try_spoiled(path, copy, content.size, "seed 5, bit flip", i);
        copy[at] ^= (unsigned char)(1 << bit);
    }
    arena_free(&arena);
}

Test(sh3d, survives_spoiled_archives, .timeout = 120) {
    Arena arena = {0};
    spoil("small.sh3d", small_file(&arena), 1, support_count(2000, 50000), 5);
    arena_free(&arena);
}

Test(sh3d, survives_spoiled_xml, .timeout = 120) {
    Arena arena = {0};
    Bytes zip = small_file(&arena), xml;
    Archive *archive;
    Error error;
    cr_assert(archive_open(zip, "small", &arena, &archive, &error));
    cr_assert(archive_read(archive, "Home.xml", SH3D_MAX_XML, &arena, &xml, &error));
    archive_close(archive);
    spoil("Home.xml", xml, 1, support_count(2000, 50000), 5);
    arena_free(&arena);
}

Test(sh3d, survives_spoiled_real_homes, .timeout = 600) {
    static const char *const FILES[] = {"2BedroomHouseWithBasement.Home.xml", "2-BedroomApartment.sh3d"};
    for (int i = 0; i < 2; i++) {
        Arena arena = {0};
        char name[128];
        snprintf(name, sizeof name, "sh3d/%s", FILES[i]);
        const char *path = support_either(name, i ? "build/maps/villa.sh3d" : "build/maps/flat.Home.xml");
        // A whole .sh3d takes 0.1 s: only some of its cuts and flips outside a soak.
        bool slow = i == 1 && !support_soak();
        spoil(path, support_read(&arena, path), slow ? 99971 : 997, slow ? 20 : 2000, 5);
        arena_free(&arena);
    }
}

// ---- real homes

// The counts of the data's index: walls and low walls, rooms, doors and windows, furniture without lamps, lamps.
Test(sh3d, counts_of_real_homes, .timeout = 60) {
    static const struct {
        const char *name;
        int storeys, walls, rooms, openings, furniture, lamps, dark;  // dark: of the lamps, without a source
    } HOMES[] = {
        {"build/maps/flat.Home.xml", 1, 22, 9, 16, 53, 10, 1},
        {"build/maps/hillside.sh3d", 4, 35, 14, 27, 62, 16, 0},
        {"build/maps/villa.sh3d", 1, 16, 9, 23, 61, 18, 0},
        {"2-BedroomApartment.sh3d", 1, 38, 7, 13, 60, 12, 0},
        {"2BedroomHouseWithBasement.Home.xml", 3, 41, 13, 27, 123, 6, 0},
        {"3BedroomApartment.Home.xml", 1, 41, 9, 21, 86, 13, 0},
        {"4-BedroomHouse.sh3d", 2, 49, 11, 21, 95, 16, 0},
        {"Studio.Home.xml", 1, 16, 5, 5, 36, 7, 0},
        {"SweetHome3D_holes.Home.xml", 2, 8, 2, 1, 1, 0, 0},
        {"edoardo90_myHomeHas2Stairs.Home.xml", 2, 14, 2, 1, 2, 0, 0},
        {"rtreffer_home-2012-2013.Home.xml", 1, 38, 6, 7, 11, 1, 0},
        {"rtreffer_home.Home.xml", 1, 57, 11, 18, 25, 0, 0},
    };
    for (size_t i = 0; i < sizeof HOMES / sizeof *HOMES; i++) {
        char name[128];
        bool ours = strchr(HOMES[i].name, '/');
        snprintf(name, sizeof name, "sh3d/%s", HOMES[i].name);
        if (!ours && !support_has_shared(name)) continue;
        Home h = {0};
        Archive *archive = NULL;
        Bytes content = support_read(&h.arena, ours ? HOMES[i].name : support_shared(name)), xml = content;
        if (strstr(name, ".sh3d"))
            cr_assert(archive_open(content, name, &h.arena, &archive, &h.error) &&
                          archive_read(archive, "Home.xml", SH3D_MAX_XML, &h.arena, &xml, &h.error),
                      "%s", h.error.text);
        h.good = sh3d_sketch(xml, archive, name, &h.arena, &h.b, &h.sketch, &h.error);
        archive_close(archive);
        cr_assert(h.good, "%s", h.error.text);
        int kinds[OBJECT_KINDS] = {0};
        for (int k = 0; k < h.b.object_count; k++)
            kinds[h.b.objects[k].kind] += strcmp(h.b.objects[k].name, "sloped ceiling") != 0;
        cr_assert_eq(h.b.storey_count, HOMES[i].storeys, "%s: %d storeys", name, h.b.storey_count);
        cr_assert_eq(h.sketch.wall_count + kinds[OBJECT_LOW_WALL], HOMES[i].walls, "%s: walls", name);
        cr_assert_eq(h.sketch.room_count, HOMES[i].rooms, "%s: %d rooms", name, h.sketch.room_count);
        cr_assert_eq(h.sketch.opening_count, HOMES[i].openings, "%s: %d openings", name,
                     h.sketch.opening_count);
        cr_assert_eq(kinds[OBJECT_FURNITURE] + kinds[OBJECT_STAIR], HOMES[i].furniture, "%s: furniture",
                     name);
        cr_assert_eq(kinds[OBJECT_LAMP], HOMES[i].lamps, "%s: %d lamps", name, kinds[OBJECT_LAMP]);
        cr_assert_eq(h.b.light_count, HOMES[i].lamps - HOMES[i].dark, "%s: %d lights", name, h.b.light_count);
        // Five pieces of the house on the hillside have no model.
        bool models = strstr(name, ".sh3d") && !strstr(name, "hillside");
        cr_assert_eq(home_note(&h, "models are not in the file") < 0, models, "%s: models", name);
        home_free(&h);
    }
}
