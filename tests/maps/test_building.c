// test_building.c - appending to a building, and the check that names every fault.
#include <criterion/criterion.h>
#include <math.h>
#include <stdio.h>

#include "engine/core/polygon.h"
#include "engine/core/random.h"
#include "maps/building/building.h"

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
        "reflectance of material 0: channel 1 is 0.9 (allowed 0 to 0.85)",
        "storey 0 (s): floor 0 m, height 0 m, slab 0.2 m (floor finite, height above 0, slab at least 0)",
        "the start (nan, 0, 0) is not finite",
        "region 1 (unnamed): hole 1 at (9.000, 1.000) lies outside",
        "region 1 ring 1 at (5.000, 1.000): signed area 1 m^2 (the outer ring counter-clockwise, holes "
        "clockwise)"};
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

// A region of a few whole metres, in whatever corner of the world: a triangle, a rectangle or a bent room.
static int random_outline(Random *random, Vec2 *out) {
    enum { MOST = 6 };
    for (;;) {
        int x0 = random_index(random, MOST), y0 = random_index(random, MOST), w = 1 + random_index(random, 3),
            h = 1 + random_index(random, 3), kind = random_index(random, 3);
        const Vec2 room[6] = {{x0, y0},         {x0 + 2 * w, y0},     {x0 + 2 * w, y0 + h},
                              {x0 + w, y0 + h}, {x0 + w, y0 + 2 * h}, {x0, y0 + 2 * h}};
        for (int i = 0; i < 6; i++) out[i] = room[i];
        if (kind == 2) return 6;
        out[2] = vec2(x0 + 2 * w, y0 + h), out[3] = vec2(x0, y0 + h);
        if (kind == 1) return 4;
        for (int i = 0; i < 3; i++) out[i] = vec2(random_index(random, MOST), random_index(random, MOST));
        if (vec2_cross(vec2_sub(out[1], out[0]), vec2_sub(out[2], out[0])) > 0) return 3;
    }
}

// The area that two such have in common, m^2: of the bent room, the two rectangles that it is made of.
static double common_area(const Vec2 *a, int a_count, const Vec2 *b, int b_count) {
    if (a_count == 6) {
        const Vec2 low[4] = {a[0], a[1], a[2], {a[0].x, a[2].y}},
                   high[4] = {{a[0].x, a[2].y}, a[3], a[4], a[5]};
        return common_area(low, 4, b, b_count) + common_area(high, 4, b, b_count);
    }
    if (b_count == 6) return common_area(b, b_count, a, a_count);
    Vec3 part[16], rest[16];
    int count = a_count;
    for (int i = 0; i < a_count; i++) part[i] = vec3(a[i].x, a[i].y, 0);
    for (int i = 0; i < b_count && count > 0; i++) {
        Vec2 p = b[i], q = b[(i + 1) % b_count];
        Vec3 n = vec3_normalize(vec3(p.y - q.y, q.x - p.x, 0));
        count = polygon_clip(part, count, (Plane){n, n.x * p.x + n.y * p.y}, 0, rest);
        for (int k = 0; k < count; k++) part[k] = rest[k];
    }
    return count > 2 ? polygon_area(part, count) : 0;
}

// Do edges of theirs run along one another, other than from the same corner to the same?
static bool touch_unshared(const Vec2 *a, int a_count, const Vec2 *b, int b_count) {
    for (int i = 0; i < a_count; i++) {
        for (int k = 0; k < b_count; k++) {
            Vec2 p = a[i], q = a[(i + 1) % a_count], r = b[k], s = b[(k + 1) % b_count],
                 along = vec2_sub(q, p);
            if (vec2_cross(along, vec2_sub(r, p)) != 0 || vec2_cross(along, vec2_sub(s, p)) != 0) continue;
            double from = vec2_dot(along, vec2_sub(r, p)), to = vec2_dot(along, vec2_sub(s, p)),
                   whole = vec2_dot(along, along);
            bool shared = fmin(from, to) == 0 && fmax(from, to) == whole;
            if (!shared && fmax(fmin(from, to), 0) < fmin(fmax(from, to), whole)) return true;
        }
    }
    return false;
}

// Proves of pairs of regions, near the origin and far off, turned by quarters, one beside or above the other, that it is told whether they
// overlap, or touch without sharing corners, and in which corner of one of them; and that nothing is told of others.
Test(building, check_knows_pairs_of_regions) {
    int told[3] = {0};
    for (uint64_t seed = 1; seed <= 6000; seed++) {
        Random random = {seed};
        Arena arena = {0};
        Vec2 outline[2][6];
        Vec2 shift = seed % 2 ? vec2(0, 0)
                              : vec2(random_index(&random, 4000) - 2000, random_index(&random, 4000) - 2000);
        int count[2], quarters = random_index(&random, 4);
        Building b = {.world = {{-5000, -5000, -9}, {5000, 5000, 9}}};
        building_add_material(&arena, &b,
                              (Material){.name = "m", .reflectance = {0.5f, 0.5f, 0.5f}, .alpha = 1});
        *ARENA_PUSH(&arena, b.storeys, b.storey_count, b.storey_capacity) = (Storey){"s", 0, 2.5, 0.2};
        // The floor of the second: as the first, above it, and above it with a gap.
        static const double FLOORS[] = {0, 0, 1, 2.5, 2.6};
        double floor = FLOORS[random_index(&random, 5)];
        for (int k = 0; k < 2; k++) {
            double xy[12];
            count[k] = random_outline(&random, outline[k]);
            for (int i = 0; i < count[k]; i++) {
                Vec2 p = outline[k][i];
                for (int turn = 0; turn < quarters; turn++) p = vec2(-p.y, p.x);
                p = vec2_add(p, shift);
                xy[2 * i] = p.x, xy[2 * i + 1] = p.y;
            }
            add_region(&arena, &b, k ? floor : 0, k ? floor + 3 : 2.5, xy, count[k]);
        }
        bool overlap = common_area(outline[0], count[0], outline[1], count[1]) > 1e-6;
        bool unshared = touch_unshared(outline[0], count[0], outline[1], count[1]);
        const char *faults[8] = {""};
        int found = building_check(&b, &arena, faults, 8);
        const char *expected = overlap && floor < 2.5                 ? "overlap"
                               : !overlap && unshared && floor <= 2.5 ? "touch without sharing vertices"
                                                                      : NULL;
        // Where one lies over the other, which corners meet is told or not.
        if (overlap && floor == 2.5) found = 0;
        told[!expected ? 0 : overlap ? 1 : 2]++;
        cr_assert_eq(found, expected != NULL, "seed %llu: %s", (unsigned long long)seed, faults[0]);
        if (expected) {
            double x, y;
            const char *at = strstr(faults[0], "near (");
            cr_assert(strstr(faults[0], expected) && at && sscanf(at, "near (%lf, %lf)", &x, &y) == 2,
                      "seed %llu: %s, not: %s", (unsigned long long)seed, expected, faults[0]);
            bool corner = false;
            for (int i = 0; i < b.point_count; i++)
                corner = corner || (b.points[i].x == x && b.points[i].y == y);
            cr_assert(corner, "seed %llu: %s: no corner", (unsigned long long)seed, faults[0]);
            char heights[64];
            snprintf(heights, sizeof heights, "between heights %.3f and 2.500", floor);
            cr_assert(!overlap || strstr(faults[0], heights), "%s", faults[0]);
        }
        arena_free(&arena);
    }
    cr_assert(told[0] > 500 && told[1] > 500 && told[2] > 200, "%d, %d, %d", told[0], told[1], told[2]);
}

// Proves that each end of an opening's line must be finite.
Test(building, check_knows_lines_of_openings) {
    Arena arena = {0};
    for (int k = 0; k < 12; k++) {
        Building b = sound_building(&arena);
        double *const ENDS[] = {&b.openings[0].line[0].x, &b.openings[0].line[0].y, &b.openings[0].line[1].x,
                                &b.openings[0].line[1].y};
        *ENDS[k % 4] = k < 4 ? NAN : k < 8 ? INFINITY : -2 * MAPS_LIMIT;
        faults_of(&b, &arena, "opening 0 (gap): its line is not finite");
    }
    arena_free(&arena);
}

// Proves that a form that there is not is named with those that there are, and that nothing else is said of such a building.
Test(building, check_names_the_forms) {
    static const int FORMS[] = {-1, BUILDING_FORMS, BUILDING_FORMS + 5};
    Arena arena = {0};
    for (int i = 0; i < 3; i++) {
        Building b = sound_building(&arena);
        b.form = FORMS[i];
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
    static const char *const expected[] = {
        "material 0 (m): alpha 2 (allowed 0 to 1)",
        "material 0 (m): mirror 0.7 beside a reflectance of 0.5 (together 0 to 1)",
        "material 0 (m): index of refraction 9 (0, or 1 to 4)",
        "polygon 0 at (0.000, 0.000, 1.000): no area",
        "object 0 (thing): leaf 7 (allowed 0 to 0)",
        "object 0 (thing): its proxy is not finite or reaches from 3 up to 0",
        "inlay 0: points 12 to 13 of 15 (at least 3, all there)",
        "inlay 0: material 0 of 1, height nan m",
        "inlay 0 at (1.000, 4.000): not convex or not counter-clockwise",
        "tour 0 (round): viewpoints 0 to 4 of 1",
        "note 0: no text, or its path lies outside the points",
        "opening 0 (gap): kind 3",
        "opening 0 (gap): storey 3 of 1",
        "opening 0 (gap): its line is not finite",
        "opening 0 (gap): open by 1.5 (allowed 0 to 1)",
        "opening 0 (gap): leaves 0 to 3 of 1",
        "opening 0 (gap): material 8 of 1",
        "leaf 0 at (0.000, 0.000): it is not finite or has no size",
        "leaf 0: corners 0 to 1 of 15 points (none, or 3 to 32)",
        "leaf 0: opening 5 of 1",
        "region 0 (unnamed): heights 0 to 2.5 m leave the world (0 to 1 m)",
        "curved shape 0: kind 5 (allowed 0 to 4)",
        "curved shape 0: polygons 0 to 5, not all of object 0; material 0 of 1",
        "curved shape 0: tolerance 0 m (above 0), top 0 (0 to 1)",
        "curved shape 0: its axes are not perpendicular, or one has no length",
        "curved shape 1: controls from 1 of 16, trims from 0 of 1",
        "curved shape 1: control 3 at (3, 0, 0), weight 0 (finite, above 0)",
        "curved shape 1: point 2 of trim 0 is (1.5, 0), weight 1 (0 to 1, above 0)",
        "curved shape 2: balls 0 to -1 of 1 (at least 1), threshold 0.5 (above 0)",
        "curved shape 2: ball 0 has radius -1, weight 1 (finite, a radius above 0)"};
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

// Proves that a portal between given cells may bend by 4 mm, and not by 5 (building_check.c): a corner is moved out of the
// plane of a rectangle, of which the plane between then lies off by a quarter.
Test(building, check_knows_bent_portals) {
    static const struct {
        double moved;
        bool sound;
    } CASES[] = {{0, true}, {0.015, true}, {-0.015, true}, {0.02, false}, {-0.02, false}, {1, false}};
    for (int i = 0; i < (int)(sizeof CASES / sizeof *CASES); i++) {
        Arena arena = {0};
        Vec3 v[4] = {{0, 0, 0}, {0, 0, 1}, {CASES[i].moved, 2, 1}, {0, 2, 0}};
        GivenPortal portal = {{0, 1}, 0, 4};
        Building b = {.form = FORM_CELLS,
                      .source = "bent",
                      .given_cell_count = 2,
                      .given_portals = &portal,
                      .given_portal_count = 1,
                      .vertices = v,
                      .vertex_count = 4,
                      .world = {{-1, 0, 0}, {1, 2, 1}}};
        const char *fault = "";
        int count = building_check(&b, &arena, &fault, 1);
        cr_expect_eq(count, !CASES[i].sound, "moved by %g: %d faults, first: %s", CASES[i].moved, count,
                     fault);
        cr_expect(CASES[i].sound || strstr(fault, "bends by"), "%s", fault);
        arena_free(&arena);
    }
}
