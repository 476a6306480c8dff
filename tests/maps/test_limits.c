// test_limits.c - limits (engine/LIMITS.md): files made to meet them are refused with a sentence that tells the place, what was found and
// what is allowed. Faults that are one of many in a table of their own reader are tested there.
#include <criterion/criterion.h>
#include <png.h>
#include <stdio.h>
#include <unistd.h>

#include "engine/core/polygon.h"
#include "maps/building/texture.h"
#include "maps/maps.h"
#include "tests/support/home_fixture.h"
#include "tests/support/hostile.h"
#include "tests/support/support.h"
#include "tests/support/wad_builder.h"
#include "visibility/vis.h"

#define PLAN "plan 1\nmaterial m #808080\nstorey s floor 0 height 2.6\nroom r 0,0 4,0 4,3 0,3\n"
#define MODEL PLAN "model k\n"
#define PATCH                                                                                                \
    "patch m 0,0,0 1,0,0 2,0,0 3,0,0 0,1,0 1,1,0 2,1,0 3,1,0 0,2,0 1,2,0 2,2,0 3,2,0 0,3,0 1,3,0 2,3,0 "     \
    "3,3,0\n"
#define TRIANGLE "v 0 0 0\nv 1 0 0\nv 0 1 0\n"
#define GLTF "{\"asset\":{\"version\":\"2.0\"},"

// `head`, `count` times `unit`, in which %d is the number, and `tail`.
typedef struct Limit {
    const char *name, *head, *unit;
    int count;
    const char *tail, *expected;
} Limit;

static const Limit LIMITS[] = {
    {"words.plan", PLAN "room q ", "%d,0 ", 299, "\n", "words.plan:5: too many words (allowed: 300 a line)"},
    {"materials.plan", PLAN, "material m%d #808080\n", 10000, "", "too many: material (allowed: 10000)"},
    {"balls.plan", MODEL "metaballs m threshold 0.5\n", "ball %d,0,1 radius 0.2\n", 101, "end\n",
     "balls.plan:107: more than 100 balls (limit)"},
    {"trims.plan", MODEL PATCH, "trim 0.1,0.1 0.2,0.1 0.2,0.2 0.1,0.1\n", 201, "end\n",
     "the patch has 201 curves of trims (limit 200)"},
    {"height.plan", "plan 1\nstorey s floor 0 height 1001\n", "", 0, "",
     "height is '1001' (allowed: a number from 0.1 to 1000 metres)"},
    {"thickness.plan", PLAN "wall 0,0 1,0 thickness 11\n", "", 0, "",
     "thickness is '11' (allowed: a number from 0.001 to 10 metres)"},
    {"far.plan", PLAN "room q 0,0 200000000,0 4,3\n", "", 0, "",
     "in metres, no blanks inside, at most 1e+08)"},
    {"corners.prt", "PRT1\n2\n1\n65 0 1 ", "(%d 0 0 ) ", 65, "\n",
     "corners.prt:4: the number of a portal's corners is `65` (allowed 3 to 64)"},
    {"nested.xml", "<?xml version='1.0'?><home>", "<furnitureGroup>", 70, "",
     "elements nested too deep (at most 64 allowed)"},
    {"elements.xml", "<?xml version='1.0'?><home>", "<a/>", 2 << 20, "</home>",
     "too many elements (at most 2097152 allowed)"},
    {"list.gltf", GLTF "\"nodes\":[", "{},", 1000000, "{}]}",
     "nodes: has 1000001 elements (allowed: 1000000)"},
    {"materials.gltf", GLTF "\"materials\":[", "{},", 10000, "{}]}",
     "materials: has 10001 elements (allowed: 10000)"},
    {"nested.gltf", "", "[", 100000, "", "maximum parsing depth reached"},
    {"placed.plan", MODEL "cylinder m 0 1 0,0 radius 1 sides 64\nend\n", "place k %d,0\n", 5000, "",
     "placed.plan:4553: the building comes to more than 300000 polygons (the limit for a file of"},
    {"shapes.plan", MODEL, "sphere m %d,0,1 radius 0.4 tolerance 0.0001\n", 100, "end\n",
     "the shapes come to more than 300000 polygons (the limit for a file of"},
};

// These are files of many megabytes.
static const Limit LARGE[] = {
    {"quads.quads", "", "quad q%d 0.5 0 0 0 0 1 0 0 1 1 0 0 1 0\n", (1 << 20) + 1, "",
     "quads.quads:1048577: more than 1048576 quads"},
    {"points.quads", "quad a 0.5 1 0 0 0 1 0 0 1 1 0 0 1 0\n", "point p%d 0.5 0.5 0 0 0 1 a\n", (1 << 20) + 1,
     "", "more than 1048576 points"},
    {"vertices.obj", "", "v 0 0 0\n", (4 << 20) + 1, "", "the model has more than 4194304 vertices"},
    {"corners.obj", TRIANGLE, "f 1 2 3\n", (16 << 20) / 3 + 1, "",
     "the model has more than 16777216 corners"},
    {"polygons.obj", TRIANGLE, "f 1 2 3\n", (4 << 20) + 1, "",
     "its faces make 4194305 triangles (allowed: 4194304)"},
    {"text.gltf", GLTF, " ", 128 << 20, "}", "bytes of JSON (allowed: 134217728"},
    {"polygons.plan", MODEL "cylinder m 0 1 0,0 radius 1 sides 64\nend\n",
     "place k %d,0  #                                                                                       "
     "                                                                                                      "
     "                                                  \n",
     64516, "", "the building comes to more than 4000000 polygons (the limit for a file of"},
};

static void refuse(Arena *arena, const char *path, const char *expected) {
    Building b;
    Error error = {""};
    cr_expect_not(maps_read(path, arena, &b, &error), "%s was read", path);
    cr_expect(strstr(error.text, expected), "no `%s` in `%s`", expected, error.text);
    cr_expect_null(strchr(error.text, '\n'), "more than a sentence: %s", error.text);
}

static void meet(const Limit *limit) {
    Arena arena = {0};
    const char *path = arena_format(&arena, "%s/%s", support_folder(&arena), limit->name);
    FILE *file = fopen(path, "w");
    cr_assert(file);
    fputs(limit->head, file);
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wformat-nonliteral"
#pragma GCC diagnostic ignored "-Wformat-extra-args"
    for (int i = 0; i < limit->count; i++) fprintf(file, limit->unit, i);
#pragma GCC diagnostic pop
    fputs(limit->tail, file);
    cr_assert_eq(fclose(file), 0);
    refuse(&arena, path, limit->expected);
    unlink(path);
    arena_free(&arena);
}

Test(limits, of_readers, .timeout = 300) {
    for (int i = 0; i < (int)(sizeof LIMITS / sizeof *LIMITS); i++) meet(&LIMITS[i]);
}

Test(limits, of_large_files, .timeout = 900) {
    if (!support_soak()) cr_skip_test("files of many megabytes: make soak");
    for (int i = 0; i < (int)(sizeof LARGE / sizeof *LARGE); i++) meet(&LARGE[i]);
}

// A small glTF file asks for much by using a mesh, or an accessor, again and again: that has a limit.
Test(limits, of_repetition) {
    static const struct {
        const char *kind, *expected;
        int count;
    } CASES[] = {{"gltf-instances",
                  "nodes[225]: its mesh makes more than 300000 polygons in all (the limit for ", 300},
                 {"gltf-sparse", "accessors[0].count: makes more than ", 100}};
    Arena arena = {0};
    for (int i = 0; i < (int)(sizeof CASES / sizeof *CASES); i++) {
        const char *path = arena_format(&arena, "%s/%s.gltf", support_folder(&arena), CASES[i].kind);
        cr_assert(hostile_write(hostile_find(CASES[i].kind), CASES[i].count, 1, path));
        refuse(&arena, path, CASES[i].expected);
        unlink(path);
    }
    arena_free(&arena);
}

static Building open_with_note(Arena *arena, const char *path, const char *expected) {
    Building b = {0};
    Error error = {""};
    cr_assert(maps_read(path, arena, &b, &error), "%s", error.text);
    bool said = false;
    for (int i = 0; i < b.note_count; i++) said = said || strstr(b.notes[i].text, expected);
    cr_expect(said, "%s: no note `%s`", path, expected);
    return b;
}

// Flights of stairs whose steps would be more polygons than a building may have: it opens, those beyond half of the polygons are
// slopes. Proves for each flight that it reaches from its foot to its top, and, by the volume between its polygons and the floor, that
// it is whole and faces outwards: n steps hold (n + 1) / 2n of their box, a slope holds half. Tolerance: the box is of whole
// centimetres, rounding in 1e8 m gives 1e-8.
Test(limits, of_stairs) {
    enum { FLIGHTS = 500, STEPS = 200 };
    Arena arena = {0};
    const char *path = arena_format(&arena, "%s/stairs.plan", support_folder(&arena));
    FILE *file = fopen(path, "w");
    cr_assert(file && fputs(PLAN, file) >= 0);
    for (int i = 0; i < FLIGHTS; i++)
        fprintf(file, "stair s%d 2,1 width 1 depth 3 height 2 steps %d angle %d\n", i, STEPS, i % 360);
    cr_assert_eq(fclose(file), 0);
    Building b = open_with_note(
        &arena, path,
        "stairs.plan:193: stair s188: their steps would take more than half of the 300000 polygons allowed");
    int slopes = 0;
    for (int i = 0; i < b.object_count; i++) {
        const Object *o = &b.objects[i];
        if (o->kind != OBJECT_STAIR) continue;
        double volume = 0;
        for (int k = o->first_polygon; k < o->first_polygon + o->polygon_count; k++) {
            const Polygon *p = &b.polygons[k];
            const Vec3 *v = b.vertices + p->first_vertex;
            Vec3 at = vec3_sub(v[0], vec3(2, 1, 0));
            volume +=
                vec3_dot(plane_of_polygon(v, p->vertex_count).n, at) * polygon_area(v, p->vertex_count) / 3;
        }
        bool slope = o->polygon_count == 4;
        slopes += slope;
        cr_expect_float_eq(volume, slope ? 3 : 3.0 * (STEPS + 1) / STEPS, 1e-8, "flight %d holds %.10g m^3",
                           i, volume);
        cr_expect(o->proxy_z0 == 0 && o->proxy_z1 == 2, "flight %d reaches from %g to %g", i, o->proxy_z0,
                  o->proxy_z1);
    }
    cr_expect_eq(slopes, 312);
    unlink(path);
    arena_free(&arena);
}

// Rooms of so many storeys, no two above one another, that the table of storeys and pieces of the plan would be too large: the first
// ones are there with their area, to the square millimetre, and the others are noted and counted as lost.
Test(limits, of_storeys) {
    enum { STOREYS = 1500, SIDE = 6 };
    Arena arena = {0};
    const char *path = arena_format(&arena, "%s/storeys.plan", support_folder(&arena));
    FILE *file = fopen(path, "w");
    cr_assert(file && fputs("plan 1\n", file) >= 0);
    for (int i = 0; i < STOREYS; i++) {
        int x = 8 * (i % 50), y = 8 * (i / 50);
        fprintf(file, "storey s%d floor %g height 2.5\nroom a %d,%d %d,%d %d,%d %d,%d\n", i, 2.75 * i, x, y,
                x + SIDE, y, x + SIDE, y + SIDE, x, y + SIDE);
    }
    cr_assert_eq(fclose(file), 0);
    Building b =
        open_with_note(&arena, path, "its outline would be one too many of 1500 storeys (allowed here: 666)");
    cr_expect_eq(b.region_count, 666);
    cr_expect_float_eq(b.drawn_area - b.lost_area, 666.0 * SIDE * SIDE, 1e-6);
    for (int i = 0; i < b.region_count; i++) cr_expect_eq(b.regions[i].z0, 2.75 * i);
    unlink(path);
    arena_free(&arena);
}

// A file of 1 GiB and a byte more, nearly all of it a hole that takes no room on the disk.
Test(limits, of_a_file) {
    Arena arena = {0};
    const char *path = arena_format(&arena, "%s/huge.plan", support_folder(&arena));
    FILE *file = fopen(path, "w");
    cr_assert(file && fputs("plan 1\n", file) >= 0 && fclose(file) == 0);
    cr_assert_eq(truncate(path, (1 << 30) + 1L), 0);
    refuse(&arena, path, "huge.plan: has 1073741825 bytes (at most 1073741824 are read)");
    arena_free(&arena);
}

// More records than 16 bits number: each line has two vertices of its own.
Test(limits, of_a_wad) {
    static const char *const NAMES[] = {"MAP01"};
    Arena arena = {0};
    Error error;
    WadMaker maker = {.arena = &arena};
    wad_two_rooms(&maker);
    while (maker.line_size <= 0xFFFF * 14) wad_line(&maker, 50, 50, 60, 60, WAD_ROOM, -1, 0, 0);
    Bytes whole = wad_file(&maker, NAMES, 1, NULL);
    const char *path = arena_format(&arena, "%s/lines.wad", support_folder(&arena));
    cr_assert(file_write(path, whole.data, whole.size, &error), "%s", error.text);
    refuse(&arena, path, "lump VERTEXES: 524288 bytes (allowed: up to 65535 records of 4 bytes each)");
    arena_free(&arena);
}

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

// Rooms that are a cell more than there may be.
Test(limits, of_cells) {
    Arena arena = {0};
    Building b = {.form = FORM_REGIONS, .source = "rows.plan"};
    for (int i = 0; i <= MAPS_MAX_CELLS; i++) {
        double x = 5 * (i % 256), y = 5 * (i / 256);
        const Vec2 corner[4] = {{x, y}, {x + 4, y}, {x + 4, y + 3}, {x, y + 3}};
        add_room(&arena, &b, corner);
    }
    CellGraph graph;
    Error error;
    VisOptions options = vis_default_options();
    cr_assert_not(vis_build_cells(&b, &options, &arena, &graph, &error));
    cr_expect_str_eq(error.text, "rows.plan: its rooms make 65537 convex cells (allowed: 65536)");
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
