// test_building.c - appending to a building, and the check that names every fault.
#include <criterion/criterion.h>
#include <math.h>
#include <stdio.h>

#include "engine/core/polygon.h"
#include "engine/core/random.h"
#include "maps/building.h"

// Proves the sRGB curve at known points (IEC 61966-2-1: 188 is 0.5028 linear, 10 is on the straight part)
// and the cap.
Test(building, colours) {
    cr_expect_float_eq(maps_linear(0), 0, 0);
    cr_expect_float_eq(maps_linear(10), 10 / 255.0 / 12.92, 1e-6);
    cr_expect_float_eq(maps_linear(188), 0.5029, 1e-3);
    cr_expect_eq(maps_linear(255), MAPS_MAX_REFLECTANCE);
    cr_expect_eq(maps_linear(-5), 0);
    Rgb c = maps_colour(0xFF00BC);
    cr_expect_eq(c.r, MAPS_MAX_REFLECTANCE);
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

static int faults_of(const Building *b, Arena *arena, const char *expected) {
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
    faults_of(&b, &arena, NULL);
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
    building_set_proxy(&b, 0.5);
    const Object *o = &b.objects[0];
    cr_expect_float_eq(vec2_length(vec2_sub(o->proxy[1], o->proxy[0])), 2, 1e-12);
    cr_expect_float_eq(vec2_length(vec2_sub(o->proxy[2], o->proxy[1])), 1, 1e-12);
    cr_expect_gt(vec2_cross(vec2_sub(o->proxy[1], o->proxy[0]), vec2_sub(o->proxy[2], o->proxy[1])), 0);
    cr_expect_float_eq(o->proxy_z0, 0.7, 0);
    cr_expect_float_eq(o->proxy_z1, 0.75, 0);
    arena_free(&arena);
}

// ---- the check

static void add_ring(Arena *arena, Building *b, const double *xy, int count) {
    *ARENA_PUSH(arena, b->rings, b->ring_count, b->ring_capacity) = (Ring){b->point_count, count};
    for (int i = 0; i < count; i++) {
        b->edge_material =
            arena_grow(arena, b->edge_material, b->point_count, &b->edge_capacity, sizeof(int));
        b->edge_material[b->point_count] = 0;
        *ARENA_PUSH(arena, b->points, b->point_count, b->point_capacity) = vec2(xy[2 * i], xy[2 * i + 1]);
    }
}

static Region *add_region(Arena *arena, Building *b, double z0, double z1, const double *xy, int count) {
    Region *r = ARENA_PUSH(arena, b->regions, b->region_count, b->region_capacity);
    *r =
        (Region){.name = "", .opening = -1, .first_ring = b->ring_count, .ring_count = 1, .z0 = z0, .z1 = z1};
    add_ring(arena, b, xy, count);
    return r;
}

// Two rooms that share the edge x = 4, the second with a hole.
static Building sound_building(Arena *arena) {
    static const double first[] = {0, 0, 4, 0, 4, 3, 0, 3}, second[] = {4, 0, 8, 0, 8, 3, 4, 3},
                        hole[] = {5, 1, 5, 2, 6, 2, 6, 1};
    Building b = {0};
    building_add_material(arena, &b, (Material){.name = "m", .reflectance = {0.5f, 0.5f, 0.5f}, .alpha = 1});
    *ARENA_PUSH(arena, b.storeys, b.storey_count, b.storey_capacity) = (Storey){"s", 0, 2.5, 0.2};
    add_region(arena, &b, 0, 2.5, first, 4);
    add_region(arena, &b, 0, 2.5, second, 4)->ring_count = 2;
    add_ring(arena, &b, hole, 4);
    *ARENA_PUSH(arena, b.openings, b.opening_count, b.opening_capacity) = (Opening){
        .kind = OPENING_PASSAGE, .name = "gap", .line = {{4, 0}, {4, 3}}, .head = 2, .region = {0, 1}};
    building_add_object(arena, &b, OBJECT_FURNITURE, "thing");
    Vec3 quad[4] = {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    building_add_polygon(arena, &b, quad, 4, 0);
    *ARENA_PUSH(arena, b.lights, b.light_count, b.light_capacity) =
        (Light){"lamp", {1, 1, 2}, 0.1, {1, 1, 1}, 0};
    *ARENA_PUSH(arena, b.viewpoints, b.viewpoint_count, b.viewpoint_capacity) =
        (Viewpoint){"door", {1, 1, 1.6}, 0, 0, 1};
    b.world = (Box){{0, 0, 0}, {8, 3, 2.5}};
    return b;
}

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
        b->materials[0].reflectance.g = 0.9f;
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

// Proves that a sound building passes and that each of 32 faults is named.
Test(building, check_names_every_fault) {
    static const char *const expected[] = {
        "finite",           "grid",          "within",          "at least 3",   "touches or crosses",
        "signed area",      "reaches from",  "floor material",  "off the grid", "overlap",
        "sharing vertices", "has material",  "rings",           "region 9",     "without a reason",
        "sill below head",  "no width",      "material 3",      "bends",        "not convex",
        "finite",           "all there",     "polygons 0 to 1", "opening -1",   "light 0",
        "object 4",         "field of view", "reflectance",     "storey 0",     "start",
        "outside",          "signed area"};
    int ways = (int)(sizeof expected / sizeof *expected);
    for (int way = -1; way < ways; way++) {
        Arena arena = {0};
        Building b = sound_building(&arena);
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

// Proves that a form that there is not is named with those that there are, and that nothing else is said of such a building.
Test(building, check_names_the_forms) {
    static const int FORMS[] = {-1, BUILDING_FORMS, BUILDING_FORMS + 5};
    Arena arena = {0};
    for (int i = 0; i < 3; i++) {
        Building b = sound_building(&arena);
        b.form = (BuildingForm)FORMS[i];
        char expected[64];
        snprintf(expected, sizeof expected, "form %d (allowed 0 to 2)", FORMS[i]);
        cr_expect_eq(faults_of(&b, &arena, expected), 1);
    }
    arena_free(&arena);
}

// Proves where outlines of one region may meet: holes in a corner of one another and of the outer ring, and no ring with itself.
Test(building, check_tells_rings_that_touch) {
    static const double OUTER[] = {0, 0, 8, 0, 8, 4, 0, 4}, HOLE[] = {1, 1, 1, 2, 2, 2, 2, 1},
                        BESIDE[] = {2, 2, 2, 3, 3, 3, 3, 2}, AT_CORNER[] = {0, 0, 0.5, 3, 1, 3.5},
                        BOW[] = {4, 1, 5, 2, 4, 3, 6, 3, 5, 2, 6, 1};
    static const struct {
        const double *ring[2];
        int count[2];
        bool sound;
    } CASES[] = {
        {{HOLE, BESIDE}, {4, 4}, true}, {{HOLE, AT_CORNER}, {4, 3}, true}, {{HOLE, BOW}, {4, 6}, false}};
    for (int i = 0; i < 3; i++) {
        Arena arena = {0};
        Building b = {.world = {{0, 0, 0}, {8, 4, 2.5}}};
        building_add_material(&arena, &b,
                              (Material){.name = "m", .reflectance = {0.5f, 0.5f, 0.5f}, .alpha = 1});
        *ARENA_PUSH(&arena, b.storeys, b.storey_count, b.storey_capacity) = (Storey){"s", 0, 2.5, 0.2};
        add_region(&arena, &b, 0, 2.5, OUTER, 4)->ring_count = 3;
        for (int k = 0; k < 2; k++) add_ring(&arena, &b, CASES[i].ring[k], CASES[i].count[k]);
        faults_of(&b, &arena, CASES[i].sound ? NULL : "touches or crosses itself near");
        arena_free(&arena);
    }
}

// The same with one of everything else: an inlay, a leaf, a tour, a note, and a ball, a patch and metaballs.
static Building detailed_building(Arena *arena) {
    static const double inlay[] = {1, 1, 2, 1, 2, 2};
    Building b = sound_building(arena);
    *ARENA_PUSH(arena, b.inlays, b.inlay_count, b.inlay_capacity) = (Inlay){b.point_count, 3, 0, 0};
    add_ring(arena, &b, inlay, 3);
    b.ring_count--;
    *ARENA_PUSH(arena, b.leaves, b.leaf_count, b.leaf_capacity) =
        (Leaf){.axis = {{4, 0}, {4, 3}}, .thickness = 0.05, .z1 = 2};
    *ARENA_PUSH(arena, b.tour_points, b.tour_point_count, b.tour_point_capacity) =
        (Viewpoint){"stop", {1, 1, 1.6}, 0, 0, 1};
    *ARENA_PUSH(arena, b.tours, b.tour_count, b.tour_capacity) = (Tour){"round", 0, 1};
    *ARENA_PUSH(arena, b.notes, b.note_count, b.note_capacity) = (Note){.text = "none"};
    for (int i = 0; i < 16; i++)
        *ARENA_PUSH(arena, b.controls, b.control_count, b.control_capacity) =
            (CurvedControl){vec3(i % 4, i / 4, 0), 1};
    *ARENA_PUSH(arena, b.trims, b.trim_count, b.trim_capacity) = (CurvedTrim){.weight = {1, 1, 1, 1}};
    *ARENA_PUSH(arena, b.balls, b.ball_count, b.ball_capacity) = (CurvedBall){{0, 0, 0}, 1, 1};
    static const CurvedKind KINDS[] = {CURVED_SPHERE, CURVED_PATCH, CURVED_METABALLS};
    for (int i = 0; i < 3; i++) {
        *ARENA_PUSH(arena, b.shapes, b.shape_count, b.shape_capacity) =
            (CurvedShape){.kind = KINDS[i],
                          .frame = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                          .trim_count = 1,
                          .ball_count = 1,
                          .threshold = 0.5,
                          .tolerance = 0.01,
                          .polygon_count = 1};
    }
    return b;
}

static void spoil_details(Building *b, int way) {
    switch (way) {
    case 0:
        b->materials[0].alpha = 2;
        break;
    case 1:
        b->materials[0].mirror = 0.7f;
        break;
    case 2:
        b->materials[0].index = 9;
        break;
    case 3:
        for (int i = 0; i < 4; i++) b->vertices[i].y = 0;
        break;
    case 4:
        b->objects[0].leaf = 7;
        break;
    case 5:
        b->objects[0].proxy_z0 = 3;
        break;
    case 6:
        b->inlays[0].point_count = 2;
        break;
    case 7:
        b->inlays[0].z = NAN;
        break;
    case 8:
        b->points[b->inlays[0].first_point + 1] = vec2(1, 4);
        break;
    case 9:
        b->tours[0].viewpoint_count = 5;
        break;
    case 10:
        b->notes[0].text = NULL;
        break;
    case 11:
        b->openings[0].kind = OPENING_KINDS;
        break;
    case 12:
        b->openings[0].storey = 3;
        break;
    case 13:
        b->openings[0].line[0].x = NAN;
        break;
    case 14:
        b->openings[0].open = 1.5;
        break;
    case 15:
        b->openings[0].leaf_count = 4;
        break;
    case 16:
        b->openings[0].material = 8;
        break;
    case 17:
        b->leaves[0].thickness = 0;
        break;
    case 18:
        b->leaves[0].corner_count = 2;
        break;
    case 19:
        b->leaves[0].opening = 5;
        break;
    case 20:
        b->world.max.z = 1;
        break;
    case 21:
        b->shapes[0].kind = CURVED_KINDS;
        break;
    case 22:
        b->shapes[0].polygon_count = 6;
        break;
    case 23:
        b->shapes[0].tolerance = 0;
        break;
    case 24:
        b->shapes[0].frame.axis[1] = vec3(1, 1, 0);
        break;
    case 25:
        b->shapes[1].first_control = 1;
        break;
    case 26:
        b->controls[3].weight = 0;
        break;
    case 27:
        b->trims[0].point[2].x = 1.5;
        break;
    case 28:
        b->shapes[2].ball_count = 0;
        break;
    case 29:
        b->balls[0].radius = -1;
        break;
    default:
        break;
    }
}

// Proves the same of these.
Test(building, check_names_faults_of_details) {
    static const char *const expected[] = {"alpha 2",
                                           "mirror 0.7 beside",
                                           "refraction 9",
                                           "no area",
                                           "leaf 7",
                                           "proxy",
                                           "at least 3",
                                           "height nan",
                                           "inlay 0 at",
                                           "viewpoints 0 to 4 of 1",
                                           "note 0",
                                           "kind 3",
                                           "storey 3 of 1",
                                           "line is not finite",
                                           "open by 1.5",
                                           "leaves 0 to 3 of 1",
                                           "material 8 of 1",
                                           "has no size",
                                           "corners 0 to 1",
                                           "opening 5 of 1",
                                           "leave the world",
                                           "kind 5",
                                           "not all of object 0",
                                           "tolerance 0 m",
                                           "not perpendicular",
                                           "controls from 1 of 16",
                                           "control 3 at",
                                           "point 2 of trim 0",
                                           "balls 0 to -1 of 1",
                                           "radius -1"};
    int ways = (int)(sizeof expected / sizeof *expected);
    for (int way = -1; way < ways; way++) {
        Arena arena = {0};
        Building b = detailed_building(&arena);
        spoil_details(&b, way);
        const char *faults[8] = {""};
        int count = building_check(&b, &arena, faults, 8);
        bool found = false;
        for (int i = 0; i < count && i < 8; i++)
            found = found || (way >= 0 && strstr(faults[i], expected[way]));
        cr_expect(way < 0 ? count == 0 : found, "case %d: %d faults, first: %s", way, count, faults[0]);
        arena_free(&arena);
    }
}

// Proves that a region which is convex as it is may have vertices off the grid, and that a dent of a tenth of a
// millimetre is none too small to be seen.
Test(building, convex_regions_may_leave_the_grid) {
    Arena arena = {0};
    Building b = sound_building(&arena);
    static const double bay[] = {-1, 0, 0, 0, 0, 1.00051, 0, 3, -1, 3.00007};
    add_region(&arena, &b, 0, 2.5, bay, 5);
    cr_expect(region_is_convex(&b, &b.regions[2]));
    b.points[b.point_count - 3].x = -0.0001;
    cr_expect_not(region_is_convex(&b, &b.regions[2]), "the wall bends inwards");
    arena_free(&arena);
}

// Proves that regions one above the other, side by side, and around one another are not taken for
// overlapping, and that small overlaps in space are.
Test(building, overlaps_in_space) {
    static const double room[] = {0, 0, 4, 0, 4, 3, 0, 3}, inner[] = {5, 1, 6, 1, 6, 2, 5, 2},
                        cross[] = {3.999, 1, 5, 1, 5, 2, 3.999, 2};
    Arena arena = {0};
    Building b = sound_building(&arena);
    b.world.max.z = 9;
    add_region(&arena, &b, 2.5, 5, room, 4);
    add_region(&arena, &b, 0, 2.5, inner, 4);
    faults_of(&b, &arena, NULL);
    add_region(&arena, &b, 4.999, 6, room, 4);
    faults_of(&b, &arena, "overlap");
    arena_free(&arena);
    b = sound_building(&arena);
    add_region(&arena, &b, 1, 2, cross, 4);
    faults_of(&b, &arena, "overlap");
    arena_free(&arena);
}

// Proves that a clipped polygon has one corner more at most, also where rounding has corners of the edge along the plane on either
// side of it, and that no corner of the rest is lost. Tolerance: the noise, along four metres.
Test(building, clipped_polygons_have_room) {
    enum { COUNT = 11 };
    const double noise = 1e-15;
    for (int turn = 0; turn < COUNT; turn++) {
        Vec3 v[COUNT], out[COUNT + 2];
        for (int i = 0; i < COUNT - 2; i++)
            v[(i + turn) % COUNT] = vec3(i * 0.5, i % 2 ? -noise * (i + 1) : noise, 0);
        v[(COUNT - 2 + turn) % COUNT] = vec3(4, 3, 0);
        v[(COUNT - 1 + turn) % COUNT] = vec3(0, 3, 0);
        out[COUNT + 1] = vec3(NAN, 0, 0);
        int kept = polygon_clip(v, COUNT, (Plane){{0, 1, 0}, 0}, 0, out);
        cr_assert(kept <= COUNT + 1 && isnan(out[COUNT + 1].x), "turn %d: %d corners", turn, kept);
        cr_assert_float_eq(polygon_area(out, kept), 12, 1e-13, "turn %d: %g m2", turn,
                           polygon_area(out, kept));
    }
}

// Proves that every kind has a name.
Test(building, names) {
    for (int i = 0; i < OPENING_KINDS; i++) cr_expect_gt(strlen(opening_kind_name((OpeningKind)i)), 0);
}
