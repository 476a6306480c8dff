// test_solid.c - polygons and prisms as a body sweeps along them and stands on them.
#include <criterion/criterion.h>

#include "engine/sim/doors.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"

// ---- geometry

// Convex, of 3 to 7 corners, flat, upright or sloping.
static Solid random_solid(Random *r, Vec3 *vertices) {
    int count = 3 + random_index(r, 5);
    Vec3 n = fixture_direction(r);
    if (random_unit(r) < 0.3) n = vec3(0, 0, 1);
    if (random_unit(r) < 0.3) n = vec3_normalize(vec3(n.x, n.y, 0));
    Vec3 u = vec3_normalize(vec3_cross(n, fabs(n.z) < 0.9 ? vec3(0, 0, 1) : vec3(1, 0, 0))),
         v = vec3_cross(n, u);
    Vec3 middle = vec3(random_between(r, -1, 1), random_between(r, -1, 1), random_between(r, 0, 2));
    double size = random_between(r, 0.05, 1.2);
    Solid s = {.vertices = vertices, .count = count, .box = box_empty()};
    for (int i = 0; i < count; i++) {
        double a = 2 * M_PI * (i + 0.6 * random_unit(r)) / count;
        vertices[i] = vec3_add(middle, vec3_add(vec3_scale(u, size * cos(a)), vec3_scale(v, size * sin(a))));
        s.box = box_add(s.box, vertices[i]);
    }
    return s;
}

// Proves that a sweep stops where the distance becomes the radius, and not before: by small steps along the way.
Test(solid, sweep_stops_where_the_distance_says) {
    enum { STEPS = 400 };
    Random r = {11};
    int hits = 0;
    for (int i = 0; i < support_count(20000, 400000); i++) {
        Vec3 vertices[8];
        Solid s = random_solid(&r, vertices);
        Band band = {random_between(&r, 0, 1), random_between(&r, 1, 2)};
        double radius = random_between(&r, 0.05, 0.5);
        Vec2 from = vec2(random_between(&r, -3, 3), random_between(&r, -3, 3)), normal;
        Vec2 way = vec2(random_between(&r, -3, 3), random_between(&r, -3, 3));
        if (solid_distance(&s, band, from) < radius) continue;
        double t = solid_sweep(&s, band, from, way, radius, &normal);
        for (int k = 0; k < STEPS; k++) {
            Vec2 at = vec2_add(from, vec2_scale(way, t * k / STEPS));
            // Tolerance: rounding of a quadratic's root, far below BODY_TOLERANCE.
            cr_assert_geq(solid_distance(&s, band, at), radius - 1e-9, "case %d: too near at %d of %d", i, k,
                          STEPS);
        }
        if (t >= 1) continue;
        hits++;
        Vec2 at = vec2_add(from, vec2_scale(way, t)), beyond = vec2_add(from, vec2_scale(way, t + 1e-6));
        cr_assert_float_eq(solid_distance(&s, band, at), radius, 1e-9, "case %d stops early", i);
        cr_assert_lt(solid_distance(&s, band, beyond), radius, "case %d stops where nothing is", i);
        cr_assert_float_eq(vec2_length(normal), 1, 1e-9);
        cr_assert_lt(vec2_dot(normal, way), 0);
    }
    cr_assert_gt(hits, 1000);
}

// Proves that the heights over a disc are those of points of the polygon over it, and that no such point is beyond.
Test(solid, levels_hold_every_point_over_the_disc) {
    Random r = {12};
    int seen = 0;
    for (int i = 0; i < support_count(20000, 400000); i++) {
        Vec3 vertices[8];
        Solid s = random_solid(&r, vertices);
        Vec2 at = vec2(random_between(&r, -1, 1), random_between(&r, -1, 1));
        double radius = random_between(&r, 0.05, 0.5), low = INFINITY, high = -INFINITY;
        Band levels;
        for (int k = 0; k < 200; k++) {
            Vec3 p = vertices[0];
            for (int c = 1; c < s.count; c++) p = vec3_lerp(p, vertices[c], pow(random_unit(&r), 1.5));
            if (hypot(p.x - at.x, p.y - at.y) >= radius) continue;
            low = fmin(low, p.z);
            high = fmax(high, p.z);
        }
        bool over = solid_levels(&s, at, radius, &levels);
        if (low > high) continue;
        seen++;
        cr_assert(over && levels.z0 <= low + 1e-9 && levels.z1 >= high - 1e-9,
                  "case %d: points from %g to %g, levels from %g to %g", i, low, high, levels.z0, levels.z1);
        // Just above and below there is nothing within the radius.
        cr_assert_geq(solid_distance(&s, (Band){levels.z1 + 1e-7, INFINITY}, at), radius - 1e-5, "case %d",
                      i);
        cr_assert_geq(solid_distance(&s, (Band){-INFINITY, levels.z0 - 1e-7}, at), radius - 1e-5, "case %d",
                      i);
    }
    cr_assert_gt(seen, 1000);
}

// Proves that the heights of a bent quadrilateral hold every point of its triangles over the disc, and are not much farther: one
// corner is off the others' plane by up to a millimetre, as is allowed.
Test(solid, levels_hold_what_is_bent) {
    Random r = {13};
    for (int i = 0; i < support_count(2000, 40000); i++) {
        Vec3 v[4] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
        double sx = random_between(&r, -0.7, 0.7), sy = random_between(&r, -0.7, 0.7);
        Solid s = {.vertices = v, .count = 4, .box = box_empty()};
        double bend = random_between(&r, -0.001, 0.001), radius = random_between(&r, 0.1, 0.4);
        for (int k = 0; k < 4; k++) {
            v[k].z = sx * v[k].x + sy * v[k].y + (k == 2 ? bend : 0);
            s.box = box_add(s.box, v[k]);
        }
        Vec2 at = vec2(random_between(&r, -0.5, 0.5), random_between(&r, -0.5, 0.5));
        Band levels, points = {INFINITY, -INFINITY};
        cr_assert(solid_levels(&s, at, radius, &levels));
        for (int k = 0; k < 400; k++) {
            // Cut from the bent corner to the one across, or between the others: below, and above the diagonal.
            double a = 2 * M_PI * k / 400, x = at.x + radius * cos(a), y = at.y + radius * sin(a);
            double along = fmin(x, y) + 1, off = fmax(0, x + y), z = sx * x + sy * y;
            for (int cut = 0; cut < 2; cut++) {
                double at_point = z + bend * (cut ? off / 2 : along / 2);
                points = (Band){fmin(points.z0, at_point), fmax(points.z1, at_point)};
            }
        }
        cr_assert(levels.z0 <= points.z0 + 1e-9 && levels.z1 >= points.z1 - 1e-9,
                  "case %d: from %g to %g, levels from %g to %g", i, points.z0, points.z1, levels.z0,
                  levels.z1);
        // Levels are two bends off the plane, of a quarter of what the corner is off; points of the rim miss its highest by 0.02 mm.
        double most = fabs(bend) + 2e-5;
        cr_assert(levels.z0 >= points.z0 - most && levels.z1 <= points.z1 + most,
                  "case %d: from %g to %g, levels from %g to %g", i, points.z0, points.z1, levels.z0,
                  levels.z1);
    }
}
