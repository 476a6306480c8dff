// test_lamp_faces.c - lights become faces: all their flux leaves from where nothing of the lamp is in its way.
#include <criterion/criterion.h>

#include "maps/building/lamp_faces.h"
#include "maps/maps.h"
#include "tests/support/fixture.h"

// A room of 4 x 3 x 2.5 m with a closed lamp from z0 to z1 in its middle, whose light sits at height z; glowing or not.
static int lamp_in_room(Arena *arena, Building *b, double z0, double z1, double z, bool glows) {
    Random random = {1};
    *b = *fixture_rooms(arena, &random, 1, 1, 1);
    b->object_count = b->polygon_count = b->vertex_count = 0;
    Material shade = {.name = "shade", .reflectance = {0.5f, 0.5f, 0.5f}, .alpha = 1};
    if (glows) shade.emission = (Rgb){3, 3, 3};
    int material = building_add_material(arena, b, shade);
    building_add_object(arena, b, OBJECT_LAMP, "lamp");
    for (int i = 0; i < 2; i++) {
        double h = i ? z1 : z0;
        Vec3 v[4] = {{1, 1, h}, {2, 1, h}, {2, 2, h}, {1, 2, h}};
        building_add_polygon(arena, b, v, 4, material);
    }
    *ARENA_PUSH(arena, b->lights, b->light_count, b->light_capacity) =
        (Light){.name = "lamp", .position = {1.5, 1.5, z}, .radius = 0.1, .flux = {5, 4, 3}, .object = 0};
    return lamp_faces_add(arena, b);
}

static void expect_flux(const Building *b, int object) {
    double watts[3] = {0};
    const Object *o = &b->objects[object];
    for (int i = o->first_polygon; i < o->first_polygon + o->polygon_count; i++) {
        const Polygon *p = &b->polygons[i];
        double area = polygon_area(b->vertices + p->first_vertex, p->vertex_count);
        Rgb e = b->materials[p->material].emission;
        watts[0] += area * (double)e.r, watts[1] += area * (double)e.g, watts[2] += area * (double)e.b;
    }
    for (int c = 0; c < 3; c++) cr_assert_float_eq(watts[c], 5 - c, 1e-5, "channel %d: %g W", c, watts[c]);
}

// Proves that a square emits the light's flux from beneath a lamp that hangs, from above one that stands, from beneath again
// where the ceiling is near; and that none is added where the lamp glows by itself.
Test(lamp_faces, shine_past_their_lamps) {
    static const struct {
        double z0, z1, z;
        bool glows;
        int added;
        double at, up;
    } CASES[] = {{1.9, 2.2, 1.95, false, 1, 1.9, -1},
                 {0.0, 1.6, 1.5, false, 1, 1.6, 1},
                 {2.3, 2.65, 2.6, false, 1, 2.3, -1},
                 {1.9, 2.2, 1.95, true, 0, 0, 0}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Arena arena = {0};
        Building b;
        cr_assert_eq(lamp_in_room(&arena, &b, CASES[i].z0, CASES[i].z1, CASES[i].z, CASES[i].glows),
                     CASES[i].added);
        if (CASES[i].added) {
            const Polygon *p = &b.polygons[b.polygon_count - 1];
            Vec3 n = plane_of_polygon(b.vertices + p->first_vertex, p->vertex_count).n;
            double off = (b.vertices[p->first_vertex].z - CASES[i].at) * CASES[i].up;
            cr_assert(n.z * CASES[i].up > 0.99 && off > 0 && off < 0.01, "case %zu: faces %g, %g m off", i,
                      n.z, off);
            expect_flux(&b, b.object_count - 1);
        }
        arena_free(&arena);
    }
}

// Proves that a light without a lamp shines from a cube all ways, outwards.
Test(lamp_faces, cube_shines_all_ways) {
    Arena arena = {0};
    Random random = {1};
    Building *b = fixture_rooms(&arena, &random, 1, 1, 1);
    Vec3 middle = {2, 1.5, 1.5};
    *ARENA_PUSH(&arena, b->lights, b->light_count, b->light_capacity) =
        (Light){.name = "ball", .position = middle, .radius = 0.05, .flux = {5, 4, 3}, .object = -1};
    cr_assert_eq(lamp_faces_add(&arena, b), 1);
    const Object *o = &b->objects[b->object_count - 1];
    cr_assert_eq(o->polygon_count, 6);
    Vec3 sum = {0, 0, 0};
    for (int i = o->first_polygon; i < o->first_polygon + 6; i++) {
        const Polygon *p = &b->polygons[i];
        Plane plane = plane_of_polygon(b->vertices + p->first_vertex, p->vertex_count);
        cr_assert_lt(plane_distance(plane, middle), 0);
        sum = vec3_add(sum, plane.n);
    }
    cr_assert_lt(vec3_length(sum), 1e-12);
    expect_flux(b, b->object_count - 1);
    arena_free(&arena);
}
