// test_mesh_input.c - meshes of any polygons: convex ones, glass, too many, a hundred thousand.
#include <criterion/criterion.h>
#include <stdio.h>
#include <time.h>

#include "engine/core/polygon.h"
#include "radiosity/mesh/mesh.h"
#include "tests/radiosity/mesh/mesh_fixture.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"

static void start(Sheets *s) {
    *s = (Sheets){.building = {.form = FORM_SOUP, .source = "sheets"}};
    building_add_material(&s->arena, &s->building,
                          (Material){.name = "stone", .reflectance = {0.5f, 0.5f, 0.5f}, .alpha = 1});
    building_add_material(&s->arena, &s->building, (Material){.name = "glass", .alpha = 0.3f});
    building_add_object(&s->arena, &s->building, OBJECT_FURNITURE, "sheets");
}

static bool finish(Sheets *s, double element, int per_patch, Error *error) {
    Building *b = &s->building;
    s->graph = (CellGraph){.building = b,
                           .objects = b->objects,
                           .polygons = b->polygons,
                           .vertices = b->vertices,
                           .object_count = b->object_count,
                           .polygon_count = b->polygon_count,
                           .vertex_count = b->vertex_count};
    s->graph.surface_first = ARENA_ARRAY(&s->arena, int, 1);
    s->graph.locator_first = ARENA_ARRAY(&s->arena, int, 2);
    s->graph.locator = (SquareGrid){.size = 1, .nx = 1, .ny = 1};
    MeshOptions options = {.element = element, .per_patch = per_patch};
    return mesh_build(&s->graph, NULL, &options, &s->arena, &s->mesh, error);
}

// Lopsided convex polygons in any plane, in grids of any fineness.
Test(mesh, convex_polygons_become_convex_elements) {
    int merged = 0;
    for (uint64_t seed = 1; seed <= (uint64_t)support_count(300, 5000); seed++) {
        Sheets s;
        Random random = {seed};
        Error error = {""};
        start(&s);
        Vec3 n = fixture_direction(&random), x = vec3_normalize(vec3_cross(n, fixture_direction(&random)));
        Vec3 y = vec3_cross(n, x), v[12], at = {random_between(&random, -1e6, 1e6), 3, -2};
        int count = 3 + random_index(&random, 10);
        double turn = random_between(&random, 0, 6.28), flat = random_between(&random, 0.05, 1);
        for (int i = 0; i < count; i++) {
            double a = turn + 6.283185307 * (i + random_between(&random, 0, 0.8)) / count;
            v[i] = vec3_add(at, vec3_add(vec3_scale(x, 2 * cos(a)), vec3_scale(y, 2 * flat * sin(a))));
        }
        building_add_polygon(&s.arena, &s.building, v, count, 0);
        bool good = finish(&s, random_between(&random, 0.05, 2), 1 + random_index(&random, 4), &error);
        cr_assert(good, "seed %llu: %s", (unsigned long long)seed, error.text);
        mesh_check_mesh(&s.mesh, s.building.vertices);
        merged += s.mesh.merged_elements;
        arena_free(&s.arena);
    }
    cr_expect_gt(merged, 100, "hardly any slivers were there to be joined");
}

Test(mesh, glass_and_what_has_no_area_are_left_out) {
    Sheets s;
    Error error = {""};
    start(&s);
    const Vec3 square[4] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const Vec3 needle[3] = {{0, 0, 0}, {1, 0, 0}, {1, 5e-8, 0}};
    // Six thousandths of a square metre, and nowhere wider than points are told apart.
    const Vec3 hair[3] = {{0, 0, 0}, {2e5, 0, 0}, {1e5, 6e-8, 0}};
    building_add_polygon(&s.arena, &s.building, square, 4, 1);
    cr_expect(!finish(&s, 0.3, 2, &error));
    cr_expect(strstr(error.text, "no polygon"), "%s", error.text);
    building_add_polygon(&s.arena, &s.building, square, 4, 0);
    // As a reader would not leave them.
    for (int i = 2; i < 4; i++) {
        building_add_polygon(&s.arena, &s.building, square, 4, 0);
        memcpy(s.building.vertices + s.building.polygons[i].first_vertex, i == 2 ? needle : hair,
               sizeof needle);
        s.building.polygons[i].vertex_count = 3;
    }
    cr_assert(finish(&s, 0.3, 2, &error), "%s", error.text);
    cr_expect_eq(s.mesh.face_count, 1);
    cr_expect_eq(s.mesh.dropped_faces, 2);
    cr_expect(s.mesh.face_of[0] == -1 && s.mesh.face_of[1] == 0 && s.mesh.face_of[2] == -1 &&
              s.mesh.face_of[3] == -1);
    arena_free(&s.arena);
}

Test(mesh, too_many_elements_are_refused) {
    Sheets s;
    Error error = {""};
    start(&s);
    const Vec3 plain[4] = {{0, 0, 0}, {1e3, 0, 0}, {1e3, 1e3, 0}, {0, 1e3, 0}};
    building_add_polygon(&s.arena, &s.building, plain, 4, 0);
    cr_expect(!finish(&s, 0.01, 2, &error));
    cr_expect(strstr(error.text, "take larger ones"), "%s", error.text);
    arena_free(&s.arena);
}

// Time grows with the polygons: 100,000 of them, in a heap of cubes that share corners and edges, take about half a second
// of one core here. The limit is wide because machines are loaded.
Test(mesh, a_hundred_thousand_polygons_are_quick) {
    enum { SIDE = 26 };
    static const int WALL[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                   {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    Sheets s;
    Error error = {""};
    start(&s);
    for (int i = 0; i < SIDE * SIDE * SIDE; i++) {
        Vec3 at = {0.5 * (i % SIDE), 0.25 + 0.5 * (i / SIDE % SIDE), 0.5 * (i / SIDE / SIDE)}, v[4];
        for (int w = 0; w < 6; w++) {
            for (int k = 0; k < 4; k++)
                v[k] = vec3_add(
                    at, vec3(0.5 * (WALL[w][k] & 1), 0.25 * (WALL[w][k] >> 1 & 1), 0.5 * (WALL[w][k] >> 2)));
            building_add_polygon(&s.arena, &s.building, v, 4, 0);
        }
    }
    clock_t before = clock();
    cr_assert(finish(&s, 0.5, 1, &error), "%s", error.text);
    double seconds = (double)(clock() - before) / CLOCKS_PER_SEC;
    printf("%d polygons: %.2f s\n", s.mesh.face_count, seconds);
    cr_expect_lt(seconds, 3);
    arena_free(&s.arena);
}
