// test_limits_of_cells.c - limits of cells, chords, corners, seams, pictures and looks for corners.
#include <criterion/criterion.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/core/polygon.h"
#include "maps/building/texture.h"
#include "maps/maps.h"
#include "tests/support/files/home_fixture.h"
#include "tests/support/files/hostile.h"
#include "tests/support/support.h"
#include "visibility/vis.h"

// A room of four corners, counter-clockwise, without walls of its own.
static void add_room(Arena *arena, Building *b, const Vec2 corner[4]) {
    Region *region = ARENA_PUSH(arena, b->regions, b->region_count, b->region_capacity);
    *region = (Region){.kind = REGION_ROOM, .name = "", .opening = -1, .first_ring = b->ring_count, .z1 = 2};
    region->ring_count = 1;
    *ARENA_PUSH(arena, b->rings, b->ring_count, b->ring_capacity) = (Ring){b->point_count, 4};
    for (int k = 0; k < 4; k++) {
        int edge = b->point_count;
        *ARENA_PUSH(arena, b->edge_material, edge, b->edge_capacity) = 0;
        *ARENA_PUSH(arena, b->points, b->point_count, b->point_capacity) = corner[k];
    }
}

// Rooms that are a cell more than there may be, all with the same outline.
Test(limits, of_cells, .timeout = 120) {
    if (!support_soak()) cr_skip_test("three gigabytes: make soak");
    Arena arena = {0};
    Building b = {.form = FORM_REGIONS, .source = "rows.plan"};
    add_room(&arena, &b, (Vec2[4]){{0, 0}, {4, 0}, {4, 3}, {0, 3}});
    const Region room = b.regions[0];
    for (int i = 0; i < MAPS_MAX_CELLS; i++)
        *ARENA_PUSH(&arena, b.regions, b.region_count, b.region_capacity) = room;
    CellGraph graph;
    Error error;
    VisOptions options = vis_default_options();
    cr_assert_not(vis_build_cells(&b, &options, &arena, &graph, &error));
    cr_expect_str_eq(error.text, "rows.plan: its rooms make more than 4194304 convex cells");
    arena_free(&arena);
}

// Proves that arc walls share 16,000 chords where they would have more, which is noted, and that each keeps two at least.
Test(limits, of_chords) {
    enum { WALLS = 1500, SHARED = 16000 };
    Arena arena = {0};
    const char *path = arena_format(&arena, "%s/arcs.xml", support_folder(&arena));
    cr_assert(hostile_write(hostile_find("home-arcs-apart"), WALLS, 1, path));
    Bytes text = support_read(&arena, path);
    Home h = home_of_bytes(text, NULL);
    cr_assert(h.good, "%s", h.error.text);
    int note = home_note(&h, "its arc walls would have "), chords = 0, arcs = 0, wanted;
    cr_assert_geq(note, 0);
    cr_expect(strstr(h.b.notes[note].text, "; they share 16000"), "%s", h.b.notes[note].text);
    cr_assert_eq(sscanf(strstr(h.b.notes[note].text, "would have "), "would have %d", &wanted), 1);
    cr_expect_gt(wanted, SHARED);
    cr_assert_eq(h.sketch.wall_count, WALLS);
    const char *at = (const char *)text.data;
    for (int i = 0; i < WALLS; i++) {
        at = strstr(at, "arcExtent='") + strlen("arcExtent='");
        // Both sides have a corner more than chords.
        int own = h.sketch.walls[i].point_count / 2 - 1;
        bool straight = strtod(at, NULL) == 0;
        cr_expect(straight ? own == 1 : own >= 2, "wall %d has %d chords", i, own);
        arcs += !straight;
        chords += straight ? 0 : own;
    }
    // Each share is rounded down, by less than a chord.
    cr_expect(chords <= SHARED && chords > SHARED - arcs, "%d chords", chords);
    home_free(&h);
    arena_free(&arena);
}

static double ring_area(const Building *b, int ring) {
    double twice = 0;
    const Ring *r = &b->rings[ring];
    for (int i = 0; i < r->point_count; i++)
        twice +=
            vec2_cross(b->points[r->first_point + i], b->points[r->first_point + (i + 1) % r->point_count]);
    return twice / 2;
}

// Walls in one line, each a centimetre on: the corners of all lie on the edges of all others. Proves that those beyond half a million
// such corners stand as objects, are counted, and leave the room's free space as the others make it.
Test(limits, of_corners_on_edges) {
    enum { WALLS = 400, MOST = 500000 };
    Arena arena = {0};
    Building b;
    Error error;
    const char *path = arena_format(&arena, "%s/line.plan", support_folder(&arena));
    FILE *file = fopen(path, "w");
    cr_assert(file);
    fputs("plan 1\nmaterial m #808080\nstorey s floor 0 height 2.6\nroom r 0,0 20,0 20,9 0,9 wall 0.1\n",
          file);
    for (int i = 0; i < WALLS; i++)
        fprintf(file, "wall %.2f,5 %.2f,5 thickness 0.1\n", 1 + 0.01 * i, 11 + 0.01 * i);
    cr_assert_eq(fclose(file), 0);
    cr_assert(maps_read(path, &arena, &b, &error), "%s", error.text);
    int objects = 0;
    cr_assert_eq(b.note_count, 1);
    cr_expect(
        strstr(b.notes[0].text, " walls cross so many others that they part no rooms and stand as objects"));
    sscanf(b.notes[0].text, "%d", &objects);
    // Each of two such walls has four corners on edges of the other.
    int taken = WALLS - objects;
    cr_expect(4 * taken * (taken - 1) <= MOST && 4 * (taken + 1) * taken > MOST, "%d walls", taken);
    cr_expect_eq(b.object_count, objects);
    int room = 0;
    while (room < b.region_count && b.regions[room].kind != REGION_ROOM) room++;
    cr_assert_lt(room, b.region_count);
    double area = 0;
    for (int i = 0; i < b.regions[room].ring_count; i++)
        area += ring_area(&b, b.regions[room].first_ring + i);
    // The walls taken, the first ones, are together a single one. Tolerance: the grid of a millimetre along its outline of 28 m.
    double length = 10 + 0.01 * (taken - 1);
    cr_expect_float_eq(area, 20 * 9 - 0.1 * length, 0.028, "%g m^2", area);
    arena_free(&arena);
}

// Triangles with one edge each on a common line: each such edge holds the corners of all shorter ones. Proves that the edges after the
// limit keep their form, and that all polygons are there with their own corners in order.
Test(limits, of_seams) {
    enum { TRIANGLES = 700, MOST = 100000 + 4 * 3 * TRIANGLES };
    Arena arena = {0};
    Building b;
    CellGraph graph;
    Error error;
    VisOptions options = vis_default_options();
    const char *path = arena_format(&arena, "%s/edges.obj", support_folder(&arena));
    cr_assert(hostile_write(hostile_find("obj-edges"), TRIANGLES, 1, path));
    cr_assert(maps_read(path, &arena, &b, &error), "%s", error.text);
    cr_assert(vis_build_cells(&b, &options, &arena, &graph, &error), "%s", error.text);
    int added = graph.vertex_count - b.vertex_count;
    // The edge at which the limit is met gets all of its corners, fewer than triangles.
    cr_expect(added >= MOST && added < MOST + TRIANGLES, "%d corners more", added);
    cr_assert_eq(graph.polygon_count, b.polygon_count);
    for (int p = 0; p < b.polygon_count; p++) {
        const Polygon *given = &b.polygons[p], *made = &graph.polygons[p];
        int found = 0;
        for (int i = 0; i < made->vertex_count && found < given->vertex_count; i++)
            found +=
                vec3_equal(graph.vertices[made->first_vertex + i], b.vertices[given->first_vertex + found]);
        cr_expect_eq(found, given->vertex_count, "polygon %d", p);
    }
    arena_free(&arena);
}

// A grey picture of so many pixels each way, all of one brightness.
static Bytes grey_png(Arena *arena, int side, int brightness) {
    png_image image = {.version = PNG_IMAGE_VERSION,
                       .width = (unsigned)side,
                       .height = (unsigned)side,
                       .format = PNG_FORMAT_GRAY};
    unsigned char *pixels = malloc((size_t)side * (size_t)side);
    cr_assert(pixels);
    memset(pixels, brightness, (size_t)side * (size_t)side);
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
    unsigned char *png = malloc(size);
    cr_assert(png && png_image_write_to_memory(&image, png, &size, 0, pixels, 0, NULL));
    Bytes out = {arena_alloc(arena, size + 1, 1), size};
    memcpy(out.data, png, size);
    free(png);
    free(pixels);
    return out;
}

// Proves that a picture of more pixels than one may have, and one that with an earlier one has more than their bytes are worth, are
// left out with a note, the colours beside them stay, and the earlier one counts. They are files of some kilobytes, in a smaller one.
Test(limits, of_pictures) {
    enum { SIDE = 5000, WIDE = 6000, BRIGHTNESS = 128 };
    Arena arena = {0};
    Bytes picture = grey_png(&arena, SIDE, BRIGHTNESS), wide = grey_png(&arena, WIDE, BRIGHTNESS);
    Rgb mean;
    // Beyond the pixels of one picture, whatever may be decoded in all.
    cr_assert_gt(WIDE * WIDE, TEXTURE_MAX_PIXELS);
    cr_expect_not(texture_mean(wide, NULL, &mean));
    cr_assert_lt(2 * SIDE * SIDE, 2 * TEXTURE_FREE_PIXELS);
    cr_assert_gt((double)(2 * SIDE * SIDE),
                 TEXTURE_FREE_PIXELS + 2.0 * TEXTURE_PIXELS_A_BYTE * (double)picture.size);
    char *home = arena_format(&arena, "<?xml version='1.0'?><home version='7000' wallHeight='250'>");
    static const char *const NAMES[] = {"wide", "first", "second"};
    for (int i = 0; i < 3; i++)
        home = arena_format(
            &arena,
            "%s<room floorColor='FFFF0000'><texture attribute='floorTexture' name='%s' image='%s' "
            "width='10' height='10'/><point x='%d' y='0'/><point x='%d' y='0'/><point x='%d' "
            "y='300'/><point x='%d' y='300'/></room>",
            home, NAMES[i], NAMES[i], 500 * i, 500 * i + 400, 500 * i + 400, 500 * i);
    home = arena_format(&arena, "%s</home>", home);
    HomeEntry entries[] = {{"Home.xml", home, strlen(home)},
                           {NAMES[0], wide.data, wide.size},
                           {NAMES[1], picture.data, picture.size},
                           {NAMES[2], picture.data, picture.size}};
    Home h = home_of_zip(entries, 4);
    cr_assert(h.good, "%s", h.error.text);
    cr_expect_geq(home_note(&h,
                            "2 textures are missing or could not be decoded, another colour stands for them: "
                            "wide, second"),
                  0);
    for (int i = 0; i < 3; i++) {
        Rgb colour = h.b.materials[h.sketch.rooms[i].floor_material].reflectance,
            expected = maps_colour(i == 1 ? BRIGHTNESS * 0x10101 : 0xFF0000);
        // Tolerance: single precision.
        cr_expect_float_eq((double)colour.r, (double)expected.r, 1e-5, "room %d", i);
        cr_expect_float_eq((double)colour.g, (double)expected.g, 1e-5, "room %d", i);
    }
    home_free(&h);
    arena_free(&arena);
}

// Strips along the diagonal, so that the box around each long side holds corners of most others; then two rooms side by side, of which
// one is the longer. Returns how many corners the surfaces of these two have beyond four each, and in `count` these surfaces.
static int corners_beside_strips(int strips, int *count) {
    Arena arena = {0};
    Error error;
    CellGraph graph;
    VisOptions options = vis_default_options();
    Building b = {.form = FORM_REGIONS, .source = "strips.plan"};
    building_add_material(&arena, &b, (Material){.name = "m", .alpha = 1});
    options.square = 100;
    for (int i = 0; i < strips; i++) {
        // Beside one another, each begins and ends somewhere else along.
        double aside = 0.004 * i, along = 100 * ((i * 7919) % strips) / strips, w = 0.002, far = 1000;
        double x = along + aside, y = along - aside;
        add_room(&arena, &b,
                 (Vec2[4]){{x, y}, {x + w, y - w}, {x + w + far, y - w + far}, {x + far, y + far}});
    }
    add_room(&arena, &b, (Vec2[4]){{-10, 0}, {-8, 0}, {-8, 4}, {-10, 4}});
    add_room(&arena, &b, (Vec2[4]){{-8, 1}, {-6, 1}, {-6, 2}, {-8, 2}});
    cr_assert(vis_build_cells(&b, &options, &arena, &graph, &error), "%s", error.text);
    int corners = 0;
    *count = 0;
    for (int c = strips; c < graph.cell_count; c++) {
        for (int o = graph.surface_first[c]; o < graph.surface_first[c + 1]; o++) {
            for (int p = 0; p < graph.objects[o].polygon_count; p++, ++*count)
                corners += graph.polygons[graph.objects[o].first_polygon + p].vertex_count - 4;
        }
    }
    arena_free(&arena);
    return corners;
}

// Proves that where looking for corners on the edges of others takes too long the rest of the surfaces keep their form: the two rooms
// have the same surfaces beside few strips and beside so many that the looks are spent on these, but without corners of each other.
Test(limits, of_looks_for_corners, .timeout = 600) {
    if (!support_soak()) cr_skip_test("a minute: make soak");
    int few, many;
    cr_expect_gt(corners_beside_strips(10, &few), 0);
    cr_expect_eq(corners_beside_strips(8000, &many), 0);
    cr_expect_eq(few, many);
}
