// test_building_check.c - every fault of a building is named by the check.
#include <criterion/criterion.h>
#include <math.h>

#include "engine/core/polygon.h"
#include "maps/building/building.h"
#include "tests/maps/building_fixture.h"

// ---- the check

enum { PLAN_WAYS = 17 };

// Each case spoils one thing of a sound building: of its plan and the openings in it here, all else below.
static void spoil_plan(Building *b, int way) {
    switch (way) {
    case 0:
        b->points[1].x = NAN;
        break;
    case 1:
        b->points[8].x = 5.0005;  // of the hole: a convex region may leave the grid
        break;
    case 2:
        b->points[1].x = 2e8;
        break;
    case 3:
        b->rings[0].point_count = 2;
        break;
    case 4:
        b->points[2] = vec2(1, 1);
        b->points[3] = vec2(4, 2);
        break;
    case 5:
        b->points[1] = vec2(0, 3);
        b->points[3] = vec2(4, 0);
        break;
    case 6:
        b->regions[0].z1 = 0;
        break;
    case 7:
        b->regions[0].floor_material = 7;
        break;
    case 8:
        b->regions[0].z0 = 0.00005;
        break;
    case 9:
        b->points[1].x = b->points[2].x = 5;
        break;
    case 10:
        b->points[2].y = 2;
        break;
    case 11:
        b->edge_material[3] = -1;
        break;
    case 12:
        b->regions[1].first_ring = 2;
        break;
    case 13:
        b->openings[0].region[1] = 9;
        break;
    case 14:
        b->openings[0].region[1] = -1;
        break;
    case 15:
        b->openings[0].sill = 2;
        break;
    case 16:
        b->openings[0].line[1] = b->openings[0].line[0];
        break;
    default:
        break;
    }
}

static void spoil(Building *b, int way) {
    switch (way) {
    case 17:
        b->polygons[0].material = 3;
        break;
    case 18:
        b->vertices[2].z = 1.5;
        break;
    case 19:
        b->vertices[2] = vec3(0.2, 0.2, 1);
        break;
    case 20:
        b->vertices[2] = vec3(INFINITY, 1, 1);
        break;
    case 21:
        b->polygons[0].vertex_count = 9;
        break;
    case 22:
        b->objects[0].polygon_count = 2;
        break;
    case 23:
        b->objects[0].plug = true;
        break;
    case 24:
        b->lights[0].position.x = NAN;
        break;
    case 25:
        b->lights[0].object = 4;
        break;
    case 26:
        b->viewpoints[0].fov = 0;
        break;
    case 27:
        b->materials[0].reflectance.g = 1.5f;
        break;
    case 28:
        b->storeys[0].height = 0;
        break;
    case 29:
        b->start.x = NAN;
        break;
    case 30:
        b->points[8] = vec2(9, 1);
        b->points[9] = vec2(9, 2);
        b->points[10] = vec2(10, 2);
        b->points[11] = vec2(10, 1);
        break;
    default:
        b->points[8] = vec2(5, 1);
        b->points[9] = vec2(6, 1);
        b->points[10] = vec2(6, 2);
        b->points[11] = vec2(5, 2);
        break;
    }
}

// Proves that a sound building passes and that each of 32 faults is named, with its place and with what was found.
Test(building, check_names_every_fault) {
    static const char *const expected[] = {
        "region 0 ring 0: point 1 at (nan, 0) (finite, within 1e+08 m)",
        "region 1 ring 1: point (5.000500, 1.000000) is off the grid of 0.001 m, and the region is not "
        "convex",
        "region 0 ring 0: point 1 at (2e+08, 0) (finite, within 1e+08 m)",
        "region 0 ring 0: points 0 to 1 of 12 (at least 3, all there)",
        "region 0 (unnamed): its outline touches or crosses itself near (4.000, 2.000)",
        "region 0 ring 0 at (0.000, 0.000): signed area -12 m^2 (the outer ring counter-clockwise, holes "
        "clockwise)",
        "region 0 (unnamed): reaches from 0 m up to 0 m",
        "region 0 (unnamed): floor material 7 of 1",
        "region 0 (unnamed): heights 0.000050, 2.500000 are off the grid of 0.001 m",
        "regions 0 (unnamed) and 1 (unnamed) overlap near (4.000, 3.000) between heights 0.000 and 2.500",
        "regions 0 (unnamed) and 1 (unnamed) touch without sharing vertices near (4.000, 3.000)",
        "region 0 ring 0: edge 3 at (0.000, 3.000) has material -1 of 1",
        "region 1 (unnamed): rings 2 to 3 of 3",
        "opening 0 (gap): region 9 of 2",
        "opening 0 (gap) at (4.000, 0.000): leads nowhere without a reason",
        "opening 0 (gap): sill 2 m, head 2 m (sill below head)",
        "opening 0 (gap) at (4.000, 0.000): it has no width",
        "polygon 0: material 3 (allowed 0 to 0)",
        "polygon 0 at (0.000, 0.000, 1.000): bends by 0.1179 m (limit 0.001)",
        "polygon 0 at (0.000, 0.000, 1.000): not convex",
        "polygon 0: vertex 2 at (inf, 1, 1) (finite, within 1e+08 m)",
        "polygon 0: vertices 0 to 8 of 4 (at least 3, all there)",
        "object 0 (thing): polygons 0 to 1 of 1",
        "object 0 (thing): opening -1 (allowed 0 to 0)",
        "light 0 (lamp): at (nan, 1, 2), radius 0.1 m (finite, at least 0)",
        "light 0 (lamp): object 4 of 1",
        "viewpoint 0 (door): eye (1, 1, 1.6), yaw 0, pitch 0, field of view 0 (finite; view between 0 and "
        "pi)",
        "reflectance of material 0: channel 1 is 1.5 (allowed 0 to 0.99)",
        "storey 0 (s): floor 0 m, height 0 m, slab 0.2 m (floor finite, height above 0, slab at least 0)",
        "the start (nan, 0, 0) is not finite",
        "region 1 (unnamed): hole 1 at (9.000, 1.000) lies outside",
        "region 1 ring 1 at (5.000, 1.000): signed area 1 m^2 (the outer ring counter-clockwise, holes "
        "clockwise)"};
    int ways = (int)(sizeof expected / sizeof *expected);
    for (int way = -1; way < ways; way++) {
        Arena arena = {0};
        Building b = building_sound_building(&arena);
        if (way >= 0) (way < PLAN_WAYS ? spoil_plan : spoil)(&b, way);
        const char *faults[8] = {""};
        int count = building_check(&b, &arena, faults, 8);
        bool found = false;
        for (int i = 0; i < count && i < 8; i++)
            found = found || (way >= 0 && strstr(faults[i], expected[way]));
        cr_expect(way < 0 ? count == 0 : found, "case %d: %d faults, first: %s", way, count, faults[0]);
        arena_free(&arena);
    }
}
