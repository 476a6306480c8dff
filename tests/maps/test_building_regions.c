// test_building_regions.c - the check knows how regions, openings and rings may touch.
#include <criterion/criterion.h>
#include <math.h>
#include <stdio.h>

#include "engine/core/polygon.h"
#include "engine/core/random.h"
#include "maps/building/building.h"
#include "tests/maps/building_fixture.h"

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
            building_add_region(&arena, &b, k ? floor : 0, k ? floor + 3 : 2.5, xy, count[k]);
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
        Building b = building_sound_building(&arena);
        double *const ENDS[] = {&b.openings[0].line[0].x, &b.openings[0].line[0].y, &b.openings[0].line[1].x,
                                &b.openings[0].line[1].y};
        *ENDS[k % 4] = k < 4 ? NAN : k < 8 ? INFINITY : -2 * MAPS_LIMIT;
        building_faults_of(&b, &arena, "opening 0 (gap): its line is not finite");
    }
    arena_free(&arena);
}

// Proves that a form that there is not is named with those that there are, and that nothing else is said of such a building.
Test(building, check_names_the_forms) {
    static const int FORMS[] = {-1, BUILDING_FORMS, BUILDING_FORMS + 5};
    Arena arena = {0};
    for (int i = 0; i < 3; i++) {
        Building b = building_sound_building(&arena);
        b.form = FORMS[i];
        char expected[64];
        snprintf(expected, sizeof expected, "form %d (allowed 0 to 2)", FORMS[i]);
        cr_expect_eq(building_faults_of(&b, &arena, expected), 1);
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
        building_add_region(&arena, &b, 0, 2.5, OUTER, 4)->ring_count = 3;
        for (int k = 0; k < 2; k++) building_add_ring(&arena, &b, CASES[i].ring[k], CASES[i].count[k]);
        building_faults_of(&b, &arena, CASES[i].sound ? NULL : "touches or crosses itself near");
        arena_free(&arena);
    }
}
