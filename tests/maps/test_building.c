// test_building.c - appending to a building, and the check that names every fault.
#include <criterion/criterion.h>
#include <math.h>

#include "engine/core/polygon.h"
#include "engine/core/random.h"
#include "maps/building/building.h"
#include "tests/maps/building_fixture.h"

// Proves the sRGB curve at known points (IEC 61966-2-1: 188 is 0.5028 linear, 10 is on the straight part)
// and the cap.
Test(building, colours) {
    cr_expect_float_eq(maps_linear(0), 0, 0);
    cr_expect_float_eq(maps_linear(10), 10 / 255.0 / 12.92, 1e-6);
    cr_expect_float_eq(maps_linear(188), 0.5029, 1e-3);
    cr_expect_eq(maps_linear(255), MAPS_MAX_COLOUR);
    cr_expect_eq(maps_linear(-5), 0);
    Rgb c = maps_colour(0xFF00BC);
    cr_expect_eq(c.r, MAPS_MAX_COLOUR);
    cr_expect_eq(c.g, 0);
    cr_expect_float_eq(c.b, 0.5029, 1e-3);
}

// Proves that equal materials are found again and that names are copied.
Test(building, materials_are_shared) {
    Arena arena = {0};
    Building b = {0};
    char name[] = "oak";
    Material oak = {.name = name, .reflectance = {0.4f, 0.3f, 0.2f}, .alpha = 1};
    cr_expect_eq(building_add_material(&arena, &b, oak), 0);
    cr_expect_eq(building_add_material(&arena, &b, oak), 0);
    oak.alpha = 0.5f;
    cr_expect_eq(building_add_material(&arena, &b, oak), 1);
    name[0] = 'X';
    cr_expect_str_eq(b.materials[0].name, "oak");
    arena_free(&arena);
}

static double area_of_polygons(const Building *b, int first) {
    double sum = 0;
    for (int i = first; i < b->polygon_count; i++) {
        sum += polygon_area(&b->vertices[b->polygons[i].first_vertex], b->polygons[i].vertex_count);
    }
    return sum;
}

// Proves that convex polygons stay whole, that concave, bent and star-shaped ones are cut into triangles of
// the same area that pass the check, and that degenerate ones vanish. Star polygons are random: 300 seeds.
Test(building, polygons_are_made_convex) {
    Arena arena = {0};
    Building b = {0};
    building_add_material(&arena, &b, (Material){.name = "m", .reflectance = {0.5f, 0.5f, 0.5f}, .alpha = 1});
    building_add_object(&arena, &b, OBJECT_FURNITURE, "thing");
    Vec3 square[6] = {{0, 0, 0}, {1, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0.5, 1, 0}, {0, 1, 0}};
    cr_expect_eq(building_add_polygon(&arena, &b, square, 6, 0), 1);
    Vec3 concave[5] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {1, 0.5, 0}, {0, 2, 0}};
    cr_expect_eq(building_add_polygon(&arena, &b, concave, 5, 0), 3);
    cr_expect_float_eq(area_of_polygons(&b, 1), 2.5, 1e-12);
    Vec3 bent[4] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.1}, {0, 1, 0}};
    cr_expect_eq(building_add_polygon(&arena, &b, bent, 4, 0), 2);
    Vec3 line[3] = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, wild[3] = {{0, 0, 0}, {NAN, 1, 1}, {2, 0, 2}};
    cr_expect_eq(building_add_polygon(&arena, &b, line, 3, 0), 0);
    cr_expect_eq(building_add_polygon(&arena, &b, wild, 3, 0), 0);
    cr_expect_eq(building_add_polygon(&arena, &b, line, 2, 0), 0);
    // A nanometre wide and 46 km long: its plane is off by 5 mm.
    Vec3 hair[3] = {{0.999, -32734.233, 32735.232}, {3.996, -2.4975, 9.99e-10}, {3.996, -2.4975, 0}};
    cr_expect_eq(building_add_polygon(&arena, &b, hair, 3, 0), 0);
    for (int seed = 1; seed <= 300; seed++) {
        Random r = {(uint64_t)seed};
        Vec3 star[90];
        int count = 5 + random_index(&r, 85), first = b.polygon_count;
        for (int i = 0; i < count; i++) {
            double a = 2 * M_PI * i / count, radius = random_between(&r, 0.5, 2);
            star[i] = vec3(radius * cos(a), radius * sin(a), 0.3 * radius * cos(a));  // in a tilted plane
        }
        building_add_polygon(&arena, &b, star, count, 0);
        cr_expect_float_eq(area_of_polygons(&b, first), polygon_area(star, count), 1e-6, "seed %d", seed);
    }
    cr_expect_eq(b.objects[0].polygon_count, b.polygon_count);
    building_faults_of(&b, &arena, NULL);
    arena_free(&arena);
}

// Proves that the proxy is the box in the turned frame.
Test(building, proxy) {
    Arena arena = {0};
    Building b = {0};
    building_add_object(&arena, &b, OBJECT_FURNITURE, "table");
    double c = cos(0.5), s = sin(0.5);
    Vec3 top[4] = {{0, 0, 0.7}, {2 * c, 2 * s, 0.7}, {2 * c - s, 2 * s + c, 0.75}, {-s, c, 0.75}};
    building_add_polygon(&arena, &b, top, 4, 0);
    building_set_proxy(&arena, &b, 0.5);
    const Object *o = &b.objects[0];
    cr_expect_float_eq(vec2_length(vec2_sub(o->proxy->corner[1], o->proxy->corner[0])), 2, 1e-12);
    cr_expect_float_eq(vec2_length(vec2_sub(o->proxy->corner[2], o->proxy->corner[1])), 1, 1e-12);
    cr_expect_gt(vec2_cross(vec2_sub(o->proxy->corner[1], o->proxy->corner[0]),
                            vec2_sub(o->proxy->corner[2], o->proxy->corner[1])),
                 0);
    cr_expect_float_eq(o->proxy->z0, 0.7, 0);
    cr_expect_float_eq(o->proxy->z1, 0.75, 0);
    arena_free(&arena);
}
