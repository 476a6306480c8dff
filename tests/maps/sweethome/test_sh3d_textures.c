// test_sh3d_textures.c - pictures of homes lie where Sweet Home 3D lays them.
//
// The figures in FILE.corners come from the program itself, version 7.0.2 of Debian: SweetHomeCorners.java beside them asks it for the
// triangles of walls, rooms, pieces and the ground that it draws with a picture, and for the places of their corners in the picture.
#include <criterion/criterion.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "engine/core/polygon.h"
#include "maps/building/texture.h"
#include "maps/maps.h"
#include "tests/maps/sweethome/corners.h"
#include "tests/support/files/home_fixture.h"
#include "tests/support/support.h"

enum { KINDS = 5 };

// Every triangle that can be seen shows what the program shows; of each kind there are at least so many.
static void expect_same(const char *home, const char *figures, bool sized, const int least[KINDS]) {
    CornersTally tallies[KINDS] = {
        {.kind = "wall"}, {.kind = "board"}, {.kind = "room"}, {.kind = "piece"}, {.kind = "ground"}};
    corners_compare(home, figures, sized, tallies, KINDS);
    for (int i = 0; i < KINDS; i++) {
        const CornersTally *t = &tallies[i];
        if (getenv("CORNERS_LIST"))
            printf("%s: %s: %d the same, %d unseen, %d missing, %d off\n", home, t->kind, t->same, t->unseen,
                   t->missing, t->off);
        cr_expect_geq(t->same, least[i], "%s: %s: %d the same", home, t->kind, t->same);
        cr_expect_eq(t->missing + t->off, 0, "%s: %s: %d missing, %d off", home, t->kind, t->missing, t->off);
    }
}

// Proves that every way of laying pictures is the program's. textures.sh3d: both sides of walls, straight and along arcs, their ends and
// jambs, with angle, scale, offset and either orientation; baseboards; floors and ceilings, stretched over their room too; pieces as a
// whole, turned, mirrored and laid down; single materials; models' own pictures; the ground. attic.sh3d, made and saved by the
// program: walls of two storeys above each other, sloped tops and ceilings, a stairwell, a tilted piece. hillside.sh3d and villa.sh3d:
// floors of rooms of many shapes, and a floor over levels a few steps apart with a hole. Their sums say how much of each kind is there.
Test(sh3d_textures, lie_as_in_sweet_home_3d) {
    static const struct {
        const char *name;
        bool sized;
        int least[KINDS];
    } HOMES[] = {{"textures", true, {222, 16, 8, 108, 22}},
                 {"attic", true, {204, 52, 59, 60, 29}},
                 {"hillside", false, {0, 0, 28, 0, 0}},
                 {"villa", false, {0, 0, 52, 0, 0}}};
    Arena arena = {0};
    for (int i = 0; i < 4; i++)
        expect_same(arena_format(&arena, "maps/buildings/%s.sh3d", HOMES[i].name),
                    arena_format(&arena, "tests/maps/sweethome/%s.corners", HOMES[i].name), HOMES[i].sized,
                    HOMES[i].least);
    arena_free(&arena);
}

// The same of a home by a stranger, of which walls, rooms and a tenth of the pieces' triangles are kept as figures.
Test(sh3d_textures, lie_so_in_a_real_home) {
    const char *home = "../shared/data/sh3d/textured-room.sh3d";
    if (access(home, R_OK) != 0) cr_skip("no %s", home);
    expect_same(home, "tests/maps/sweethome/textured-room.corners", false, (const int[]){90, 0, 4, 20, 0});
}

// The counts of the comparison for one kind of figures, which are given as text.
static CornersTally tally_of(const char *kind, const char *figures) {
    Arena arena = {0};
    Error error;
    CornersTally tally = {.kind = kind};
    char *path = arena_format(&arena, "%s/figures", support_folder(&arena));
    cr_assert(file_write(path, figures, strlen(figures), &error), "%s", error.text);
    corners_compare("maps/buildings/textures.sh3d", path, true, &tally, 1);
    arena_free(&arena);
    return tally;
}

// Proves that the comparison sees what it is to see: a picture that lies 3 cm off (of 50 cm, 0.06); one where no surface of ours is; and
// that a triangle is unseen behind a solid alone, not where that has a gap, nor where it ends before the triangle does.
Test(sh3d_textures, the_comparison_notices) {
#define NORTH "wall 32x64 1.06 -1.06 0 "
#define REST " 6.94 -1.06 0 11.76 1 6.94 -1.06 2.5 11.76 -1.5\n"
#define HOLDS " 0 0 0.5 -2 7.5 -2 7.5 0 0.5 0\n"
#define AWAY "wall 32x64 1.06 -1.26 0 0 1 6.94 -1.26 0 11.76 1 6.94 -1.26 2.5 11.76 -1.5\n"
    CornersTally same = tally_of("wall", NORTH "0 1" REST), moved = tally_of("wall", NORTH "0.06 1" REST),
                 away = tally_of("wall", AWAY), hidden = tally_of("wall", "solid 0 3" HOLDS AWAY),
                 gap = tally_of("wall", "solid 0 3" HOLDS "gap 0 3" HOLDS AWAY),
                 half = tally_of("wall", "solid 0 1" HOLDS AWAY);
    cr_expect(same.same == 1 && same.off + same.missing + same.unseen == 0);
    cr_expect(moved.off == 1 && moved.same == 0);
    cr_expect(away.missing == 1 && away.same == 0);
    cr_expect(hidden.unseen == 1 && hidden.missing == 0);
    cr_expect(gap.missing == 1 && gap.unseen == 0);
    cr_expect(half.missing == 1 && half.unseen == 0);
}

// Proves that images that are missing, cut short or too large in their header cost one sentence and leave the colour that the home states,
// and that seventy textures stay within the texels of a building. The sample's own pictures are taken; a quarter of what is left
// each is above their sides, so none is halved.
Test(sh3d_textures, broken_and_many) {
    static const unsigned char CUT[] = "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x20\0\0\0\x20\x08\x06\0\0\0",
                               HUGE[] = "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x40\0\0\0\x40\0\x08\x06\0\0\0";
    Arena arena = {0};
    Error error;
    Bytes sample, image;
    Archive *archive;
    cr_assert(file_read("maps/buildings/textures.sh3d", SIZE_MAX, &arena, &sample, &error), "%s", error.text);
    cr_assert(archive_open(sample, "sample", &arena, &archive, &error));
    cr_assert(archive_read(archive, "crate", ARCHIVE_MAX_ENTRY, &arena, &image, &error));
    archive_close(archive);
    enum { MANY = 70 };
    HomeEntry entries[MANY + 3];
    char *xml = arena_format(&arena, "<home>" HOME_ROOM);
    static const char *const BAD[] = {"missing", "cut", "huge"};
    for (int i = 0; i < MANY + 3; i++)
        xml = arena_format(
            &arena,
            "%s<room floorColor='FF0000FF'><texture attribute='floorTexture' name='t%d' width='%d' "
            "height='20' "
            "image='%s'/><point x='%d' y='0'/><point x='%d' y='0'/><point x='%d' y='300'/></room>",
            xml, i, 10 + i, i < MANY ? arena_format(&arena, "i%d", i) : BAD[i - MANY], 500 * (i + 1),
            500 * (i + 1) + 400, 500 * (i + 1) + 400);
    xml = arena_format(&arena, "%s</home>", xml);
    entries[0] = (HomeEntry){"Home.xml", xml, strlen(xml)};
    for (int i = 0; i < MANY; i++)
        entries[i + 1] = (HomeEntry){arena_format(&arena, "i%d", i), image.data, image.size};
    entries[MANY + 1] = (HomeEntry){"cut", CUT, sizeof CUT - 1};
    entries[MANY + 2] = (HomeEntry){"huge", HUGE, sizeof HUGE - 1};
    Home h = home_of_zip(entries, MANY + 3);
    cr_assert(h.good, "%s", h.error.text);
    cr_expect_eq(h.b.texture_count, MANY + 1);
    cr_expect_eq(h.b.texture_map_count, MANY + 1);
    cr_expect_geq(home_note(&h, "3 textures are missing or could not be decoded"), 0);
    double texels = 0;
    for (int i = 1; i < h.b.texture_count; i++) texels += h.b.textures[i].width * h.b.textures[i].height;
    cr_expect_eq(texels, MANY * 64.0 * 64, "of %d allowed", TEXTURE_MOST_TEXELS);
    const SketchRoom *last = &h.sketch.rooms[h.sketch.room_count - 1];
    const Material *floor = &h.b.materials[last->floor_material];
    cr_expect(floor->texture == 0 && floor->reflectance.r == 0 && floor->reflectance.b > 0.8f);
    home_free(&h);
    arena_free(&arena);
}

// Proves that what is seen through a picture's holes is never an occluder, that a wall stays one, and that a colour of a piece
// replaces its picture.
Test(sh3d_textures, holes) {
    Arena arena = {0};
    Building b = {0};
    Error error;
    cr_assert(maps_read("maps/buildings/textures.sh3d", &arena, &b, &error), "%s", error.text);
    int leaves = 0, coloured = 0;
    for (int i = 0; i < b.object_count; i++) {
        const Material *m = &b.materials[b.polygons[b.objects[i].first_polygon].material];
        if (strcmp(b.objects[i].name, "leaves") == 0) {
            // Half the squares are holes, without two of the three marked ones among them.
            cr_expect_float_eq((double)m->alpha, 1 - 30.0 / 64, 1e-6, "%g", (double)m->alpha);
            leaves++;
        }
        if (strcmp(b.objects[i].name, "coloured") != 0) continue;
        cr_expect_eq(m->texture, 0);
        coloured++;
    }
    cr_expect(leaves == 1 && coloured == 1);
    cr_expect_gt(b.sky_texture, 0);
    cr_expect_float_eq(b.sky_start, -2 * M_PI * 0.1, 1e-12);
    for (int i = 0; i < b.point_count; i++)
        if (b.edge_material[i] >= 0) cr_expect_eq(b.materials[b.edge_material[i]].alpha, 1.0f);
    arena_free(&arena);
}

// Any home: HOME_FILE with figures HOME_CORNERS. CORNERS_LIST tells what is compared, and each fault.
Test(sh3d_textures, lie_so_in_a_given_home) {
    const char *home = getenv("HOME_FILE"), *figures = getenv("HOME_CORNERS");
    if (!home || !figures) cr_skip("no home is given");
    expect_same(home, figures, false, (const int[KINDS]){0});
}
