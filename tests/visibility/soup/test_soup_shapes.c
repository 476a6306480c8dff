// test_soup_shapes.c - walls without thickness, cracks, concave rooms, glass, and nothing.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "tests/support/soup_fixture.h"
#include "tests/visibility/soup/soup_checks.h"
#include "tests/visibility/soup/soup_scenes.h"

// ---- shapes

// Proves that a wall without thickness parts two rooms, and also when it stands there twice.
Test(soup, walls_without_thickness) {
    for (int copies = 1; copies <= 3; copies++) {
        Arena arena = {0};
        Building *b = soup_closed_room(&arena, vec3(8, 3, 2.5));
        for (int i = 0; i < copies; i++) soup_fixture_wall(&arena, b, 0, 5, 0, 3, 0, 2.5, NULL, 0, 0);
        CellGraph g = soup_make(&arena, b);
        cr_assert_not(soup_connected(&g, vec3(2, 1, 1), vec3(7, 1, 1)));
        soup_check_soup(&g, b, (uint64_t)copies, 2000);
        arena_free(&arena);
    }
}

// Proves that cracks of 1e-7 m and steps of 1e-7 m between polygons of a wall let nothing through, that the wall is one
// plane all the same, and that a slit of 1 cm does let through.
Test(soup, cracks) {
    static const double widths[] = {0, 1e-7, 1e-2};
    for (int i = 0; i < 3; i++) {
        Arena arena = {0};
        Building *b = soup_closed_room(&arena, vec3(8, 3, 2.5));
        double gap = widths[i], off = i == 1 ? 1e-7 : 0;
        soup_fixture_wall(&arena, b, 0, 5, 0, 1, 0, 2.5, NULL, 0, 0);
        soup_fixture_wall(&arena, b, 0, 5 + off, 1 + gap, 2, 0, 2.5, NULL, 0, 0);
        soup_fixture_wall(&arena, b, 0, 5 - off, 2, 3, 0, 2.5, NULL, 0, 0);
        CellGraph g = soup_make(&arena, b);
        cr_assert_eq(soup_connected(&g, vec3(2, 1, 1), vec3(7, 1, 1)), i == 2, "a crack of %g m", gap);
        int rooms = 0;
        for (int c = 0; c < g.cell_count; c++) rooms += !g.cells[c].outdoors;
        cr_assert_eq(rooms, 2, "a crack of %g m makes %d rooms", gap, rooms);
        cr_assert_eq(g.dropped_slivers > 0, i == 1, "cracks that are closed are counted");
        arena_free(&arena);
    }
}

// Proves that a room round a corner is seen into, and that its cells are no more than a bend needs.
Test(soup, concave_room) {
    Arena arena = {0};
    Building *b = soup_fixture_new(&arena);
    const Vec3 floor[2][4] = {{{0, 0, 0}, {6, 0, 0}, {6, 2, 0}, {0, 2, 0}},
                              {{0, 2, 0}, {2, 2, 0}, {2, 6, 0}, {0, 6, 0}}};
    for (int i = 0; i < 2; i++) {
        for (int z = 0; z < 2; z++) {
            Vec3 up = {0, 0, z * 2.5};
            const Vec3 *f = floor[i];
            soup_fixture_quad(&arena, b, vec3_add(f[0], up), vec3_add(f[1], up), vec3_add(f[2], up),
                              vec3_add(f[3], up), 0);
        }
    }
    soup_fixture_wall(&arena, b, 1, 0, 0, 6, 0, 2.5, NULL, 0, 0);
    soup_fixture_wall(&arena, b, 0, 6, 0, 2, 0, 2.5, NULL, 0, 0);
    soup_fixture_wall(&arena, b, 1, 2, 2, 6, 0, 2.5, NULL, 0, 0);
    soup_fixture_wall(&arena, b, 0, 2, 2, 6, 0, 2.5, NULL, 0, 0);
    soup_fixture_wall(&arena, b, 1, 6, 0, 2, 0, 2.5, NULL, 0, 0);
    soup_fixture_wall(&arena, b, 0, 0, 0, 6, 0, 2.5, NULL, 0, 0);
    CellGraph g = soup_make(&arena, b);
    unsigned char indoors[4096];
    cr_assert_eq(soup_reachable(&g, vis_locate(&g, vec3(5, 1, 1), -1), indoors), 2);
    cr_assert(indoors[vis_locate(&g, vec3(1, 5, 1), -1)]);
    soup_check_soup(&g, b, 3, 3000);
    arena_free(&arena);
}

// Proves that glass parts nothing.
Test(soup, glass) {
    Arena arena = {0};
    Building *b = soup_closed_room(&arena, vec3(8, 3, 2.5));
    soup_fixture_quad(&arena, b, vec3(5, 0, 0), vec3(5, 3, 0), vec3(5, 3, 2.5), vec3(5, 0, 2.5), 1);
    CellGraph g = soup_make(&arena, b);
    cr_assert_eq(vis_locate(&g, vec3(2, 1, 1), -1), vis_locate(&g, vec3(7, 1, 1), -1));
    arena_free(&arena);
}

// Proves that a single polygon, and several in one plane, make cells, and that a soup without any is refused.
Test(soup, flat_and_empty) {
    Arena arena = {0};
    Building *b = soup_fixture_new(&arena);
    VisOptions options = vis_default_options();
    CellGraph g;
    Error error = {""};
    cr_assert_not(vis_build_cells(b, &options, &arena, &g, &error));
    cr_assert_str_eq(error.text, "soup: has no polygons");
    soup_fixture_quad(&arena, b, vec3(0, 0, 0), vec3(1, 0, 0), vec3(1, 1, 0), vec3(0, 1, 0), 0);
    g = soup_make(&arena, b);
    soup_check_portals(&g);
    cr_assert(soup_connected(&g, vec3(0.5, 0.5, 0.1), vec3(0.5, 0.5, -0.1)), "around the edge");
    soup_fixture_quad(&arena, b, vec3(3, 0, 0), vec3(4, 0, 0), vec3(4, 1, 0), vec3(3, 1, 0), 0);
    g = soup_make(&arena, b);
    soup_check_portals(&g);
    arena_free(&arena);
}
