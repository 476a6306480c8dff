// test_quads.c - the reader of .quads scenes, and building_check on buildings of polygons alone.
#include <criterion/criterion.h>
#include <stdio.h>

#include "tests/support/files/soups.h"
#include "tests/support/support.h"

extern const MapsReader MAPS_READER_QUADS;

static void refuse(const char *text, const char *expected) {
    soups_refuse(&MAPS_READER_QUADS, "t.quads", text, expected);
}

static void accept(Arena *arena, const char *text, Building *b) {
    soups_accept(&MAPS_READER_QUADS, "t.quads", text, arena, b);
}

// Names, reflectances and exitances become objects and materials; corners stay in their order; equal pairs share one
// material.
Test(quads, statements) {
    Arena arena = {0};
    Building b;
    accept(&arena,
           "# a comment\n\n quad floor 0.3 0  0 0 0  4 0 0  4 3 0  0 3 0 # and another\r\n"
           "quad lamp 0 100  1 1 2  1 2 2  2 2 2  2 1 2\n"
           "quad rug 0.3 0\t0 0 .5  4 0 +0.5  4 3 5e-1  0 3 0.5\n"
           "point p 1 1 0  0 0 1 floor\npoint q 1 1 2 0 0 -1 lamp",
           &b);
    cr_assert(b.form == FORM_SOUP && b.object_count == 3 && b.polygon_count == 3 && b.material_count == 2);
    cr_expect_str_eq(b.objects[1].name, "lamp");
    cr_expect_eq(b.objects[1].first_polygon, 1);
    const Material *floor = &b.materials[b.polygons[0].material],
                   *lamp = &b.materials[b.polygons[1].material];
    cr_expect(floor->reflectance.g == 0.3f && floor->emission.r == 0 && floor->alpha == 1);
    cr_expect(lamp->reflectance.b == 0 && lamp->emission.b == 100);
    cr_expect_eq(b.polygons[0].material, b.polygons[2].material);
    cr_expect(vec3_equal(b.vertices[2], vec3(4, 3, 0)) && vec3_equal(b.vertices[5], vec3(1, 2, 2)));
    cr_expect(b.world.min.z == 0 && b.world.max.z == 2 && b.start.x == 2 && b.start.z == 1);
    cr_expect_eq(b.note_count, 0);
    arena_free(&arena);
}

// Changes on reading are noted: reflectances above the limit, bent and concave quads, sizes no building has.
Test(quads, changes_are_noted) {
    Arena arena = {0};
    Building b;
    accept(&arena,
           "quad white 0.995 0  0 0 0  4 0 0  4 3 0  0 3 0\nquad mirror 1 0  0 0 1  4 0 1  4 3 1  0 3 1\n",
           &b);
    cr_expect_eq(
        soups_notes(&b, "2 colours reflect more than 0.99 and were capped, `white` first; the most was 1"),
        1);
    cr_expect_eq(b.materials[b.polygons[1].material].reflectance.r, MAPS_MAX_REFLECTANCE);
    accept(&arena,
           "quad bent 0.5 0  0 0 0  4 0 0  4 3 0.5  0 3 0\nquad dart 0.5 0  0 0 0  2 0.5 0  4 0 0  2 3 0\n",
           &b);
    cr_expect_eq(b.polygon_count, 4);
    cr_expect_eq(b.object_count, 2);
    cr_expect_eq(b.objects[1].polygon_count, 2);
    cr_expect_eq(soups_notes(&b, "2 quads are bent or concave"), 1);
    accept(&arena, "quad tiny 0.5 0  0 0 0  .1 0 0  .1 .1 0  0 .1 0\n", &b);
    cr_expect_eq(soups_notes(&b, "0.1 m wide"), 1);
    accept(&arena, "quad town 0.5 0  0 0 0  10000 0 0  10000 10 0  0 10 0\n", &b);
    cr_expect_eq(soups_notes(&b, "10000 m wide"), 1);
    arena_free(&arena);
}

// Every fault is refused with its line, what was found and what is allowed.
Test(quads, faults) {
    static const char Q[] = "quad a 0.5 0  0 0 0  4 0 0  4 3 0  0 3 0\n";
    static const struct {
        const char *more, *expected;
    } CASES[] = {
        {"lamp b", "t.quads:2: begins with `lamp` (allowed: quad, point)"},
        {"quad", "t.quads:2: the name of a quad is `the end of the line`"},
        {"quad b 1.5 0", "t.quads:2: the reflectance is `1.5` (allowed 0 to 1)"},
        {"quad b -0.1 0", "the reflectance is `-0.1`"},
        {"quad b 0.5 nan", "the exitance is `nan` (allowed 0 to 1e+09)"},
        {"quad b 0.5 -1", "the exitance is `-1`"},
        {"quad b 0.5 1 # 0 0 0", "a coordinate is `#`"},
        {"quad b 0.5 0  0 0 0  4 0 0  4 3 0  0 3", "a coordinate is `the end of the line`"},
        {"quad b 0.5 0  0 0 0  4 0 0  4 3 0  0 3 2147483648",
         "a coordinate is `2147483648` (allowed -1e+08 to"},
        {"quad b 0.5 0  0 0 0  4 0 0  4 3 0  0 3 inf", "a coordinate is `inf`"},
        {"quad b 0.5 0  0 0 0  4 0 0  4 3 0  0 3 0x1", "a coordinate is `0x1`"},
        {"quad b 0.5 0  0 0 0  4 0 0  4 3 0  0 3 0 7",
         "found `7` after the quad (expected the end of the line)"},
        {"quad b 0.5 0  0 0 0  4 0 0  4 0 0  0 0 0", "the quad b has an area of 0 m^2"},
        {"quad b 0.5 0  0 0 0  4 3 0  4 0 0  0 2 0", "the outline of the quad b crosses itself"},
        {"\nquad a 0.5 0  0 0 1  4 0 1  4 3 1  0 3 1", "t.quads:3: the quad a was declared on line 1"},
        {"point p 0 0 0 0 0 1 b",
         "t.quads:2: a point lies on the quad b (allowed: one of the file's 1 quads)"},
        {"point p 0 0 0 0 0 2 a", "a component of the normal is `2`"},
        {"point p 0 0 0 0 0 1", "the quad of a point is `the end of the line`"},
    };
    Arena arena = {0};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++)
        refuse(arena_format(&arena, "%s%s", Q, CASES[i].more), CASES[i].expected);
    refuse("", "t.quads: holds no polygon");
    refuse("# nothing\n", "t.quads: holds no polygon");
    char *longest = arena_format(&arena, "quad %0101d 0 0", 7);
    refuse(longest,
           "the name of a quad is `0000000000000000000000000000000` (allowed: a word of 1 to 100 bytes)");
    // Materials are counted, not quads.
    size_t size = 0;
    char *many = arena_alloc(&arena, 80, 10001);
    for (int i = 0; i < 10001; i++)
        size += (size_t)sprintf(many + size, "quad q%d 0.5 %d  0 0 0  4 0 0  4 3 0  0 3 0\n", i, i);
    refuse(many, "t.quads:10001: more than 10000 different pairs");
    arena_free(&arena);
}

// The check refuses what a building of polygons alone, or of given cells, does not hold.
Test(quads, check_of_forms) {
    Arena arena = {0};
    Building b, c;
    const char *fault = "";
    accept(&arena, "quad a 0.5 0  0 0 0  4 0 0  4 3 0  0 3 0\n", &b);
    Storey storey = {"s", 0, 2, 0.2};
    c = b, c.storeys = &storey, c.storey_count = 1;
    cr_expect(building_check(&c, &arena, &fault, 1) > 0 && strstr(fault, "has 1 storeys (allowed 0)"), "%s",
              fault);
    c = b, c.given_cell_count = 2;
    cr_expect(building_check(&c, &arena, &fault, 1) > 0 && strstr(fault, "2 given cells"), "%s", fault);
    c = b, c.form = FORM_CELLS;
    cr_expect(building_check(&c, &arena, &fault, 1) > 0 && strstr(fault, "has 1 objects"), "%s", fault);
    c = b, c.form = BUILDING_FORMS;
    cr_expect(building_check(&c, &arena, &fault, 1) > 0 && strstr(fault, "form 3"), "%s", fault);
    c = b, c.start.x = NAN;
    cr_expect(building_check(&c, &arena, &fault, 1) > 0 && strstr(fault, "the start"), "%s", fault);
    GivenPortal portal = {{0, 1}, 0, 4};
    Building cells = {.form = FORM_CELLS,
                      .given_cell_count = 2,
                      .given_portals = &portal,
                      .given_portal_count = 1,
                      .vertices = b.vertices,
                      .vertex_count = 4};
    cr_expect_eq(building_check(&cells, &arena, &fault, 1), 0, "%s", fault);
    static const struct {
        GivenPortal portal;
        const char *expected;
    } CASES[] = {{{{0, 2}, 0, 4}, "cell 2 (allowed 0 to 1)"}, {{{-1, 1}, 0, 4}, "cell -1"},
                 {{{1, 1}, 0, 4}, "from cell 1 to itself"},   {{{0, 1}, 0, 2}, "vertices 0 to 1 of 4"},
                 {{{0, 1}, 1, 4}, "vertices 1 to 4 of 4"},    {{{0, 1}, -1, 3}, "vertices -1 to 1 of 4"}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        portal = CASES[i].portal;
        cr_expect(building_check(&cells, &arena, &fault, 1) > 0 && strstr(fault, CASES[i].expected), "%s",
                  fault);
    }
    static const struct {
        Vec3 corner[4];
        const char *expected;
    } OUTLINES[] = {{{{0, 0, 0}, {NAN, 0, 0}, {1, 1, 0}, {0, 1, 0}}, "vertex 1 at (nan, 0, 0)"},
                    {{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}, "no area"},
                    {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0.1}, {0, 1, 0}}, "bends by 0.02"}};
    portal = (GivenPortal){{0, 1}, 0, 4};
    for (size_t i = 0; i < sizeof OUTLINES / sizeof *OUTLINES; i++) {
        memcpy(cells.vertices, OUTLINES[i].corner, sizeof OUTLINES[i].corner);
        cr_expect(building_check(&cells, &arena, &fault, 1) > 0 && strstr(fault, OUTLINES[i].expected), "%s",
                  fault);
    }
    arena_free(&arena);
}

// The scenes the bake is held against come in whole: every statement `quad` is an object of one polygon.
Test(quads, reference_scenes) {
    static const char *const SCENES[] = {"tests/seeds/boxes.quads", "tests/seeds/two-rooms.quads",
                                         "radiosity/boxA.quads", "radiosity/twoRoom.quads"};
    for (size_t i = 0; i < sizeof SCENES / sizeof *SCENES; i++) {
        Arena arena = {0};
        Building b;
        Error error = {""};
        if (i >= 2 && !support_has_shared(SCENES[i])) continue;
        const char *path = i < 2 ? SCENES[i] : support_shared(SCENES[i]),
                   *text = (const char *)support_read(&arena, path).data;
        int quads = 0;
        for (const char *at = text; (at = strstr(at, "\nquad ")); at++) quads++;
        cr_assert(maps_read(path, &arena, &b, &error), "%s", error.text);
        cr_expect(b.form == FORM_SOUP && b.object_count == quads && b.polygon_count == quads, "%s: %d of %d",
                  path, b.polygon_count, quads);
        cr_expect_eq(b.note_count, 0);
        arena_free(&arena);
    }
}

Test(quads, survives_damage, .timeout = 120) {
    static const char TEXT[] =
        "# scene\nquad floor 0.3 0  0 0 0  4 0 0  4 3 0  0 3 0\nquad lamp 0 100  1 1 2  1 2 2 "
        " 2 2 2  2 1 2\npoint p 1 1 0  0 0 1 floor\n";
    soups_damage(&MAPS_READER_QUADS, "t.quads", TEXT, sizeof TEXT - 1, 5, support_count(4000, 400000));
}
