// building_fixture.c - see the header.
#include "tests/maps/building_fixture.h"

#include <criterion/criterion.h>
#include <math.h>

#include "engine/core/polygon.h"
#include "engine/core/random.h"
#include "maps/building/building.h"

int building_faults_of(const Building *b, Arena *arena, const char *expected) {
    const char *faults[8] = {""};
    int count = building_check(b, arena, faults, 8);
    if (!expected) {
        cr_expect_eq(count, 0, "%s", faults[0]);
    } else {
        cr_expect_geq(count, 1, "expected: %s", expected);
        cr_expect(count && strstr(faults[0], expected), "found: %s; expected: %s", faults[0], expected);
    }
    return count;
}

void building_add_ring(Arena *arena, Building *b, const double *xy, int count) {
    *ARENA_PUSH(arena, b->rings, b->ring_count, b->ring_capacity) = (Ring){b->point_count, count};
    for (int i = 0; i < count; i++) {
        b->edge_material =
            arena_grow(arena, b->edge_material, b->point_count, &b->edge_capacity, sizeof(int));
        b->edge_material[b->point_count] = 0;
        *ARENA_PUSH(arena, b->points, b->point_count, b->point_capacity) = vec2(xy[2 * i], xy[2 * i + 1]);
    }
}

Region *building_add_region(Arena *arena, Building *b, double z0, double z1, const double *xy, int count) {
    Region *r = ARENA_PUSH(arena, b->regions, b->region_count, b->region_capacity);
    *r =
        (Region){.name = "", .opening = -1, .first_ring = b->ring_count, .ring_count = 1, .z0 = z0, .z1 = z1};
    building_add_ring(arena, b, xy, count);
    return r;
}

Building building_sound_building(Arena *arena) {
    static const double first[] = {0, 0, 4, 0, 4, 3, 0, 3}, second[] = {4, 0, 8, 0, 8, 3, 4, 3},
                        hole[] = {5, 1, 5, 2, 6, 2, 6, 1};
    Building b = {0};
    building_add_material(arena, &b, (Material){.name = "m", .reflectance = {0.5f, 0.5f, 0.5f}, .alpha = 1});
    *ARENA_PUSH(arena, b.storeys, b.storey_count, b.storey_capacity) = (Storey){"s", 0, 2.5, 0.2};
    building_add_region(arena, &b, 0, 2.5, first, 4);
    building_add_region(arena, &b, 0, 2.5, second, 4)->ring_count = 2;
    building_add_ring(arena, &b, hole, 4);
    *ARENA_PUSH(arena, b.openings, b.opening_count, b.opening_capacity) = (Opening){
        .kind = OPENING_PASSAGE, .name = "gap", .line = {{4, 0}, {4, 3}}, .head = 2, .region = {0, 1}};
    building_add_object(arena, &b, OBJECT_FURNITURE, "thing");
    Vec3 quad[4] = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    building_add_polygon(arena, &b, quad, 4, 0);
    *ARENA_PUSH(arena, b.lights, b.light_count, b.light_capacity) =
        (Light){.name = "lamp", .position = {1, 1, 2}, .radius = 0.1, .flux = {1, 1, 1}, .object = 0};
    *ARENA_PUSH(arena, b.viewpoints, b.viewpoint_count, b.viewpoint_capacity) =
        (Viewpoint){"door", {1, 1, 1.6}, 0, 0, 1};
    b.world = (Box){{0, 0, 0}, {8, 3, 2.5}};
    return b;
}
