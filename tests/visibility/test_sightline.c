// test_sightline.c - sightlines in plan against brute force.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "tests/visibility/vis_fixture.h"
#include "visibility/sightline.h"

// Proves that the incremental sightline agrees with brute force on chains of portals of convex cells, degenerate
// ones (small integer coordinates: shared ends, collinear ends) among them.
Test(sightline, agrees_with_brute_force) {
    int found = 0, lost = 0;
    for (uint64_t seed = 1; seed <= 20000; seed++) {
        Random random = {seed};
        Vec2 left[16], right[16], l[16], r[16];
        Sightline line = {.left = l, .right = r, .capacity = 16};
        int grid = seed % 2 ? 8 : 1000, count = 0;
        for (int tries = 0; tries < 400 && count < 10; tries++) {
            Vec2 a = vec2(random_index(&random, grid), random_index(&random, grid) + count * grid / 4);
            Vec2 b = vec2(random_index(&random, grid), random_index(&random, grid) + count * grid / 4);
            if (vec2_equal(a, b)) continue;
            if (count > 0) {
                Vec2 pl = left[count - 1], pr = right[count - 1];
                // Beyond the last portal, and the last one before this: a convex cell lies between.
                if (orient2d(pr, pl, a) > 0 || orient2d(pr, pl, b) > 0) continue;
                if (orient2d(b, a, pl) < 0 || orient2d(b, a, pr) < 0) continue;
                if (orient2d(pr, pl, a) == 0 && orient2d(pr, pl, b) == 0) continue;
            }
            left[count] = a;
            right[count] = b;
            SightlineUndo undo;
            bool expected = vis_check_separable(left, right, count + 1);
            bool got = sightline_push(&line, a, b, &undo);
            cr_assert_eq(got, expected, "seed %llu, portal %d", (unsigned long long)seed, count);
            if (!got) {
                lost++;
                continue;
            }
            found++;
            if (random_unit(&random) < 0.3) {  // undo must restore
                sightline_pop(&line, &undo);
                continue;
            }
            count++;
        }
    }
    cr_assert(found > 10000 && lost > 10000, "the chains are too easy: %d crossed, %d not", found, lost);
}

// The same of segments that lie anyhow, as where floors are crossed between: what a line crosses is never lost, and
// in general position nothing else is kept.
Test(sightline, holds_for_any_segments) {
    int found = 0, lost = 0;
    for (uint64_t seed = 1; seed <= 20000; seed++) {
        Random random = {seed};
        Vec2 left[16], right[16], l[16], r[16];
        Sightline line = {.left = l, .right = r, .capacity = 16};
        int grid = seed % 2 ? 8 : 1000000, count = 0;
        for (int tries = 0; tries < 40 && count < 10; tries++) {
            // Mostly along some direction, so that lines are found; a tenth anyhow.
            int shift = random_index(&random, 10) ? grid / 3 : 0;
            Vec2 a = vec2(random_index(&random, grid), random_index(&random, grid) + shift);
            Vec2 b = vec2(random_index(&random, grid), random_index(&random, grid) - shift);
            if (vec2_equal(a, b)) continue;
            left[count] = a;
            right[count] = b;
            SightlineUndo undo;
            bool got = sightline_push(&line, a, b, &undo);
            cr_assert(got || !vis_check_crossed_inside(left, right, count + 1), "seed %llu, portal %d",
                      (unsigned long long)seed, count);
            cr_assert(!got || grid == 8 || vis_check_separable(left, right, count + 1),
                      "seed %llu, portal %d", (unsigned long long)seed, count);
            found += got;
            lost += !got;
            count += got;
            if (got && random_unit(&random) < 0.3) {
                sightline_pop(&line, &undo);
                count--;
            }
        }
    }
    cr_assert(found > 10000 && lost > 10000, "the segments are too easy: %d crossed, %d not", found, lost);
}
