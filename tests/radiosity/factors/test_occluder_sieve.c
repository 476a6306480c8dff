// test_occluder_sieve.c - the sieve names all occluders that hide any of a polygon, and few others.
#include <criterion/criterion.h>
#include <math.h>

#include "engine/core/random.h"
#include "radiosity/factors/analytic.h"
#include "radiosity/factors/occluder_sieve.h"

enum { OCCLUDERS = 600, POLYGONS = 200 };

// A triangle about a random direction, as wide as `width` times its distance, 1 to 10 m away.
static void triangle(Random *random, double width, Vec3 out[3]) {
    Vec3 middle =
        vec3(random_between(random, -1, 1), random_between(random, -1, 1), random_between(random, -0.2, 1));
    double away = random_between(random, 1, 10) / vec3_length(middle);
    for (int i = 0; i < 3; i++) {
        Vec3 off =
            vec3(random_between(random, -1, 1), random_between(random, -1, 1), random_between(random, -1, 1));
        out[i] = vec3_scale(vec3_add(middle, vec3_scale(off, width)), away);
    }
}

static double seen(const Vec3 *polygon, const AnalyticOccluder *occluder, int count, const int *which) {
    AnalyticSight sight = {0};
    analytic_visible_among(polygon, 3, -1, occluder, which, count, analytic_sight_add, &sight);
    return sight.share;
}

// Proves that what the sieve leaves out hides nothing: polygons among 600 narrow and wide triangles are seen as they are where all of
// these are asked, but for the rounding of some hundred cuts; and that of narrow ones it leaves out four in five.
Test(occluder_sieve, leaves_out_what_hides_nothing) {
    Random random = {7};
    Arena arena = {0};
    AnalyticOccluder *occluder = ARENA_ARRAY(&arena, AnalyticOccluder, OCCLUDERS);
    Plane *edge = ARENA_ARRAY(&arena, Plane, 3 * OCCLUDERS);
    OccluderSieve *sieve = occluder_sieve_new(OCCLUDERS, &arena);
    for (int round = 0; round < 2; round++) {
        // The second time the sieve has forgotten the first ones.
        int count = 0, hidden = 0, asked = 0, found;
        occluder_sieve_clear(sieve);
        for (int i = 0; i < OCCLUDERS; i++) {
            Vec3 v[3];
            triangle(&random, i % 20 == 0 ? 0.8 : 0.05, v);
            if (!analytic_occluder(v, 3, i, edge + 3 * count, &occluder[count])) continue;
            occluder_sieve_add(sieve, v, 3);
            count++;
        }
        for (int i = 0; i < POLYGONS; i++) {
            Vec3 v[3];
            bool narrow = i % 10 != 0;
            triangle(&random, narrow ? 0.05 : 0.8, v);
            const int *which = occluder_sieve_ask(sieve, v, 3, &found);
            for (int k = 1; k < found; k++) cr_assert_lt(which[k - 1], which[k]);
            cr_assert(found == 0 || (which[0] >= 0 && which[found - 1] < count));
            double all = seen(v, occluder, count, NULL), among = seen(v, occluder, found, which);
            cr_expect_float_eq(among, all, 1e-12, "polygon %d: %.15g of all, %.15g of %d", i, all, among,
                               found);
            hidden += all < 0.99 * analytic_point(v, 3);
            asked += narrow ? found : 0;
        }
        cr_expect_gt(hidden, POLYGONS / 2, "else nothing is tested");
        cr_expect_lt(asked, 0.2 * count * (0.9 * POLYGONS), "%g occluders of a narrow polygon",
                     asked / (0.9 * POLYGONS));
    }
    arena_free(&arena);
}
