// test_bezier_trim.c - trims of patches: which points they keep, against winding numbers of dense outlines; rays through
// trimmed patches; where curves meet, against densely sampled ones.
#include <criterion/criterion.h>

#include "engine/bench/ray_patches.h"
#include "engine/core/random.h"
#include "tests/support/support.h"
#include "visibility/bezier/bezier_trim.h"
#include "visibility/rays/curved_rays.h"

static Vec2 point_of(const CurvedTrim *c, double s) {
    double r = 1 - s, b[4] = {r * r * r, 3 * r * r * s, 3 * r * s * s, s * s * s}, w = 0;
    Vec2 p = {0, 0};
    for (int k = 0; k < 4; k++) {
        p = vec2_add(p, vec2_scale(c->point[k], b[k] * c->weight[k]));
        w += b[k] * c->weight[k];
    }
    return vec2_scale(p, 1 / w);
}

// Closed loops of wild curves that share their ends. Returns how many curves.
static int random_loops(Random *random, CurvedTrim *curves) {
    int count = 0;
    for (int loop = 1 + random_index(random, 3); loop > 0; loop--) {
        int first = count, edges = 1 + random_index(random, 4);
        for (int i = 0; i < edges; i++, count++) {
            CurvedTrim *c = &curves[count];
            for (int k = 0; k < 4; k++) {
                c->point[k] = vec2(random_between(random, -0.1, 1.1), random_between(random, -0.1, 1.1));
                c->weight[k] = random_between(random, 0.3, 3);
            }
            if (i > 0) c->point[0] = curves[count - 1].point[3];
        }
        curves[count - 1].point[3] = curves[first].point[0];
    }
    return count;
}

enum { OUTLINE = 2000 };

// Odd crossings of a dense outline; `near`: the point is so near to it that this may be wrong.
static bool inside(const CurvedTrim *curves, int count, Vec2 at, bool *near) {
    bool in = false;
    *near = false;
    for (int i = 0; i < count; i++) {
        Vec2 before = curves[i].point[0];
        for (int k = 1; k <= OUTLINE; k++) {
            Vec2 here = k == OUTLINE ? curves[i].point[3] : point_of(&curves[i], k / (double)OUTLINE);
            double step = vec2_length(vec2_sub(here, before));
            *near |= vec2_length(vec2_sub(at, here)) < 2 * step + 1e-6;
            if ((before.y <= at.y) != (here.y <= at.y)) {
                double x = before.x + (here.x - before.x) * (at.y - before.y) / (here.y - before.y);
                in ^= x > at.x;
            }
            before = here;
        }
    }
    return in;
}

// Points anywhere, at the very height of a curve's ends too, where lines count twice or not at all if they are careless.
Test(bezier_trim, keeps_what_winds_oddly, .timeout = 300) {
    int kept = 0, sure = 0;
    for (int round = 0; round < support_count(60, 5000); round++) {
        Arena arena = {0};
        Random random = {(uint64_t)round};
        CurvedTrim curves[12];
        CurvedWork work = {0};
        int count = random_loops(&random, curves);
        Trim *trim = trim_new(curves, count, &arena);
        for (int i = 0; i < 30; i++) {
            Vec2 at = {random_unit(&random), random_unit(&random)};
            if (i % 3 == 0) at.y = curves[random_index(&random, count)].point[0].y;
            bool near, in = inside(curves, count, at, &near);
            if (near) continue;
            sure++;
            cr_assert_eq(trim_keeps(trim, at, &work), in, "seed %d: (%.9f, %.9f)", round, at.x, at.y);
            kept += in;
        }
        cr_assert_eq(work.undecided, 0);
        arena_free(&arena);
    }
    cr_assert(kept > sure / 10 && sure > 900, "%d of %d", kept, sure);
}

// A rectangle that is said to be kept, or cut off, is so everywhere.
Test(bezier_trim, rectangles, .timeout = 60) {
    int decided[3] = {0};
    for (int round = 0; round < 1000; round++) {
        Arena arena = {0};
        Random random = {(uint64_t)round};
        CurvedTrim curves[12];
        CurvedWork work = {0};
        Trim *trim = trim_new(curves, random_loops(&random, curves), &arena);
        for (int i = 0; i < 30; i++) {
            double width = random_between(&random, 0.005, 0.1);
            Vec2 low = {random_unit(&random), random_unit(&random)}, high = {low.x + width, low.y + width};
            int state = trim_state(trim, low, high);
            decided[state]++;
            for (int k = 0; k < 20 && state != TRIM_SOME_KEPT; k++) {
                Vec2 at = {random_between(&random, low.x, high.x), random_between(&random, low.y, high.y)};
                cr_assert_eq(trim_keeps(trim, at, &work), state == TRIM_KEPT, "seed %d", round);
            }
        }
        arena_free(&arena);
    }
    cr_assert(decided[TRIM_KEPT] > 1000 && decided[TRIM_CUT_OFF] > 1000, "%d kept, %d cut off",
              decided[TRIM_KEPT], decided[TRIM_CUT_OFF]);
}

// A ray hits a trimmed patch where it hits the whole one at a place that the loops keep.
Test(bezier_trim, trimmed_patches) {
    Arena arena = {0};
    Building b = ray_patch_building(RAY_PATCHES - 1, 1, &arena);
    CurvedShape shapes[2] = {b.shapes[0], b.shapes[0]};
    shapes[1].trim_count = 0;
    b.shapes = shapes;
    b.shape_count = 2;
    CurvedRays *rays = curved_rays_new(&b, &arena);
    Box box = curved_rays_box(rays, 1);
    int kept = 0, cut = 0;
    for (int i = 0; i < 20000; i++) {
        Random random = {(uint64_t)i};
        Vec3 p = {random_between(&random, box.min.x, box.max.x),
                  random_between(&random, box.min.y, box.max.y), 0};
        Vec3 d = vec3_normalize(vec3(random_between(&random, -1, 1), random_between(&random, -1, 1), -1));
        Ray ray = {vec3_sub(p, vec3_scale(d, 5)), d, 0, INFINITY};
        RayHit all[32], hits[32];
        int whole = curved_rays_all(rays, 1, &ray, all, 32, NULL),
            count = curved_rays_all(rays, 0, &ray, hits, 32, NULL), at = 0;
        for (int k = 0; k < whole; k++) {
            // The loops are three circles.
            double r[3] = {hypot(all[k].u - 0.5, all[k].v - 0.5) - 0.45,
                           hypot(all[k].u - 0.4, all[k].v - 0.55) - 0.2,
                           hypot(all[k].u - 0.75, all[k].v - 0.3) - 0.1};
            bool keep = (r[0] < 0) ^ (r[1] < 0) ^ (r[2] < 0);
            if (fmin(fabs(r[0]), fmin(fabs(r[1]), fabs(r[2]))) < 1e-9) continue;
            keep ? kept++ : cut++;
            cr_assert(!keep || (at < count && hits[at].t == all[k].t), "seed %d: hit %d at u %g v %g is lost",
                      i, k, all[k].u, all[k].v);
            at += keep;
        }
        cr_assert_eq(at, count, "seed %d: %d hits, not %d", i, count, at);
    }
    cr_assert(kept > 3000 && cut > 3000);
    arena_free(&arena);
}
