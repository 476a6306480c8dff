// test_limits.c - limits (engine/LIMITS.md): files made to meet them are refused with a sentence that tells the place, what was found and
// what is allowed. Faults that are one of many in a table of their own reader are tested there.
#include <criterion/criterion.h>
#include <stdio.h>
#include <unistd.h>

#include "engine/core/polygon.h"
#include "maps/maps.h"
#include "tests/support/files/hostile.h"
#include "tests/support/files/wad_builder.h"
#include "tests/support/support.h"

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
        cr_expect(o->proxy->z0 == 0 && o->proxy->z1 == 2, "flight %d reaches from %g to %g", i, o->proxy->z0,
                  o->proxy->z1);
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
    bool *there = ARENA_ARRAY(&arena, bool, STOREYS);
    for (int i = 0; i < b.region_count; i++) {
        int storey = (int)lround(b.regions[i].z0 / 2.75);
        cr_assert(storey >= 0 && storey < 666 && !there[storey]);
        cr_expect_eq(b.regions[i].z0, 2.75 * storey);
        there[storey] = true;
    }
    unlink(path);
    arena_free(&arena);
}

// A file of 2 GiB, nearly all of it a hole that takes no room on the disk.
Test(limits, of_a_file) {
    Arena arena = {0};
    const char *path = arena_format(&arena, "%s/huge.plan", support_folder(&arena));
    FILE *file = fopen(path, "w");
    cr_assert(file && fputs("plan 1\n", file) >= 0 && fclose(file) == 0);
    cr_assert_eq(truncate(path, (off_t)MAPS_LARGEST_FILE + 1), 0);
    refuse(&arena, path, "huge.plan: has 2147483648 bytes (at most 2147483647 are read)");
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
