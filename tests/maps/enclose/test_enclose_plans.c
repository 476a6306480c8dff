// test_enclose_plans.c - free space of random plans, of real homes and of the office, by their areas and samples.
#include <criterion/criterion.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/random.h"
#include "tests/support/draft_fixture.h"
#include "tests/support/support.h"

// ---- random plans

static double volume(const Building *b) {
    double sum = 0;
    for (int i = 0; i < b->region_count; i++)
        sum += draft_region_area(b, &b->regions[i]) * (b->regions[i].z1 - b->regions[i].z0);
    return sum;
}

static bool in_wall(const Draft *d, const SketchWall *w, Vec2 p, double margin) {
    // Walls of the generator are rectangles: inside all four sides, either way round.
    const Vec2 *q = &d->s.points[w->first_point];
    for (int i = 0; i < 4; i++) {
        Vec2 side = vec2_sub(q[(i + 1) % 4], q[i]);
        double length = vec2_length(side);
        if (length == 0 || vec2_cross(side, vec2_sub(p, q[i])) / length < margin) return false;
    }
    return true;
}

// Points in and around the building: each in at most one region, none in a wall. Of those spread over the
// world the tally counts how many are free, and how many the volumes of the regions promise.
typedef struct Tally {
    double found, expected, variance;  // of sampled points in free space
} Tally;

static void sample(const Draft *d, Random *r, uint64_t seed, bool openings, Tally *tally) {
    enum { POINTS = 400 };
    int inside = 0;
    Box world = d->b.world;
    for (int i = 0; i < POINTS; i++) {
        // Half of them near the plan, where things happen; the other half for the volume.
        bool all = i % 2;
        Vec3 p = all ? vec3(random_between(r, world.min.x, world.max.x),
                            random_between(r, world.min.y, world.max.y),
                            random_between(r, world.min.z, world.max.z))
                     : vec3(random_between(r, -1, 12), random_between(r, -1, 10), random_between(r, -1, 9));
        int count = draft_regions_at(d, p.x, p.y, p.z, NULL);
        cr_assert_leq(count, 1, "seed %llu: (%.4f, %.4f, %.4f) in %d regions", (unsigned long long)seed, p.x,
                      p.y, p.z, count);
        inside += all && count == 1;
        for (int w = 0; !openings && count == 1 && w < d->s.wall_count; w++) {
            const SketchWall *wall = &d->s.walls[w];
            bool bounds = wall->z1 >= d->b.storeys[wall->storey].floor + DRAFT_HEIGHT - 0.01;
            // Margin: slivers and the grid move a side by at most 4 mm. Tall walls may end at the floor above.
            bool in = bounds && p.z > wall->z0 && p.z < wall->z0 + DRAFT_HEIGHT &&
                      in_wall(d, wall, vec2(p.x, p.y), 0.004);
            cr_assert_not(in, "seed %llu: (%.4f, %.4f, %.4f) is free in %s", (unsigned long long)seed, p.x,
                          p.y, p.z, wall->place);
        }
    }
    double box = (world.max.x - world.min.x) * (world.max.y - world.min.y) * (world.max.z - world.min.z),
           n = POINTS / 2;
    double share = volume(&d->b) / box;
    cr_assert_leq(share, 1 + 1e-9, "seed %llu: regions fill %g of the world", (unsigned long long)seed,
                  share);
    tally->found += inside;
    tally->expected += n * share;
    tally->variance += n * share * (1 - share);
}

// Proves that whatever is drawn becomes a building that passes the check, in which no two regions overlap,
// walls are solid, and free and solid space make up the world.
Test(enclose, random_plans, .timeout = 400) {
    int count = support_count(400, 20000), empty = 0;
    Tally tally = {0, 0, 0};
    for (int seed = 1; seed <= count; seed++) {
        Random r = {(uint64_t)seed};
        int storeys = 1 + random_index(&r, 3);
        bool openings = random_index(&r, 4) > 0;
        Draft d = draft_new(storeys);
        d.s.ground = random_index(&r, 3) ? 0 : random_between(&r, -1, 3);
        for (int k = 0; k < storeys; k++) draft_random_storey(&d, &r, k, openings);
        Error error = {""};
        if (maps_enclose(&d.s, &d.b, &d.arena, &error)) {
            const char *faults[1];
            int found = building_check(&d.b, &d.arena, faults, 1);
            cr_assert_eq(found, 0, "seed %d: %d faults, first: %s", seed, found, faults[0]);
            sample(&d, &r, (uint64_t)seed, openings, &tally);
        } else {
            cr_assert(strstr(error.text, "empty"), "seed %d: %s", seed, error.text);
            empty++;
        }
        draft_free(&d);
    }
    cr_expect_lt(empty, count / 10);
    // Tolerance: 5 standard deviations of a sum of independent trials.
    cr_expect_float_eq(tally.found, tally.expected, 5 * sqrt(tally.variance), "%g points free, %g expected",
                       tally.found, tally.expected);
}

// ---- the same plan, looked at otherwise

// A quarter turn to the left, or a mirror across the line x = 0; whole metres aside.
static Vec2 moved_point(Vec2 p, bool mirror) {
    return mirror ? vec2(7 - p.x, p.y - 2) : vec2(3 - p.y, p.x + 5);
}

static void move_sketch(Draft *d, bool mirror) {
    for (int i = 0; i < d->s.point_count; i++) d->s.points[i] = moved_point(d->s.points[i], mirror);
    for (int i = 0; i < d->s.wall_count; i++)
        d->s.walls[i].angle = mirror ? M_PI - d->s.walls[i].angle : d->s.walls[i].angle + M_PI / 2;
    for (int i = 0; i < d->s.opening_count; i++) {
        SketchOpening *o = &d->s.openings[i];
        o->centre = moved_point(o->centre, mirror);
        o->angle = mirror ? M_PI - o->angle : o->angle + M_PI / 2;
    }
}

// Proves that a plan turned by a quarter, or mirrored, is the same building: what is free at a point, and of which kind, is so at the
// point where it went. Tolerance: of points a thousandth, since the grid and ties of slivers are no mirrors of themselves.
Test(enclose, turned_and_mirrored_plans_are_the_same, .timeout = 100) {
    int points = 0, different = 0, free = 0;
    for (int seed = 1; seed <= support_count(60, 5000); seed++) {
        Draft d[3];
        Random r;
        bool good = true;
        for (int k = 0; k < 3; k++) {
            r = (Random){(uint64_t)seed + 70000};
            int storeys = 1 + random_index(&r, 2);
            d[k] = draft_new(storeys);
            for (int i = 0; i < storeys; i++) draft_random_storey(&d[k], &r, i, true);
            if (k > 0) move_sketch(&d[k], k == 2);
            Error error = {""};
            good = maps_enclose(&d[k].s, &d[k].b, &d[k].arena, &error) && good;
        }
        for (int k = 1; good && k < 3; k++) {
            const Box *from = &d[0].b.world, *to = &d[k].b.world;
            Vec2 p = moved_point(vec2(from->min.x, from->min.y), k == 2),
                 q = moved_point(vec2(from->max.x, from->max.y), k == 2);
            // Whole millimetres outwards, either way.
            cr_expect_lt(fabs(fmin(p.x, q.x) - to->min.x) + fabs(fmax(p.x, q.x) - to->max.x), 0.01,
                         "seed %d: world", seed);
            cr_expect_lt(fabs(fmin(p.y, q.y) - to->min.y) + fabs(fmax(p.y, q.y) - to->max.y), 0.01,
                         "seed %d: world", seed);
            cr_expect(from->min.z == to->min.z && from->max.z == to->max.z, "seed %d: heights", seed);
        }
        for (int i = 0; good && i < 300; i++) {
            Vec3 p = vec3(random_between(&r, -1, 12), random_between(&r, -1, 10), random_between(&r, -1, 6));
            int kind = draft_kind_at(&d[0], p.x, p.y, p.z);
            for (int k = 1; k < 3; k++) {
                Vec2 q = moved_point(vec2(p.x, p.y), k == 2);
                different += draft_kind_at(&d[k], q.x, q.y, p.z) != kind;
                points++;
            }
            free += kind >= 0;
        }
        for (int k = 0; k < 3; k++) draft_free(&d[k]);
    }
    cr_expect_leq(different, points / 1000, "%d of %d points differ", different, points);
    cr_expect_gt(free, points / 20);
}
