// test_sh3d_damage.c - homes are told by their content, survive damage, and real ones have their counts.
#include <criterion/criterion.h>
#include <stdio.h>
#include <string.h>

#include "engine/core/random.h"
#include "maps/maps.h"
#include "tests/support/files/home_fixture.h"
#include "tests/support/support.h"

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
            kinds[h.b.objects[k].kind] += strcmp(h.b.objects[k].name, "sloped ceiling") != 0 &&
                                          strcmp(h.b.objects[k].name, "baseboard") != 0;
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
