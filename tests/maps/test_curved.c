// test_curved.c - curved shapes: points of patches, polygons within their tolerance, closed and of the right size, trims, and
// what is refused.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "engine/core/random.h"
#include "maps/curved/curved_field.h"
#include "maps/curved/curved_patch.h"
#include "tests/maps/curved_shapes.h"
#include "tests/support/curved_fixture.h"
#include "tests/support/support.h"

// ---- points of patches

typedef struct Homogeneous {
    double c[4];
} Homogeneous;

// The four controls become the point at t, by halving gone wrong by no polynomial: de Casteljau's corner cutting.
static Homogeneous cut_corners(const Homogeneous given[4], double t) {
    Homogeneous p[4];
    memcpy(p, given, sizeof p);
    for (int left = 3; left > 0; left--)
        for (int i = 0; i < left; i++)
            for (int k = 0; k < 4; k++) p[i].c[k] = (1 - t) * p[i].c[k] + t * p[i + 1].c[k];
    return p[0];
}

static Vec3 de_casteljau(const CurvedControl *control, double u, double v) {
    Homogeneous rows[4], row[4];
    for (int j = 0; j < 4; j++) {
        for (int i = 0; i < 4; i++) {
            const CurvedControl *c = &control[4 * j + i];
            row[i] = (Homogeneous){
                {c->weight * c->point.x, c->weight * c->point.y, c->weight * c->point.z, c->weight}};
        }
        rows[j] = cut_corners(row, u);
    }
    Homogeneous p = cut_corners(rows, v);
    return vec3(p.c[0] / p.c[3], p.c[1] / p.c[3], p.c[2] / p.c[3]);
}

// Proves that points agree with de Casteljau's algorithm, derivatives with differences of them, and the borders' curves with
// the patch. Tolerances: rounding of sums of 16 terms; of central differences over 1e-5, whose error is its square.
Test(curved, points_and_derivatives) {
    Random random = {1};
    for (int n = 0; n < 200; n++) {
        CurvedControl control[PATCH_CONTROLS], border[4];
        curved_random_patch(&random, control);
        double u = curved_between(&random, 0.01, 0.99), v = curved_between(&random, 0.01, 0.99), h = 1e-5;
        PatchPoint at = curved_patch_at(control, u, v);
        Vec3 right = de_casteljau(control, u, v);
        cr_assert_lt(vec3_length(vec3_sub(at.point, right)), 1e-13);
        cr_assert_lt(vec3_length(vec3_sub(curved_patch_point(control, u, v), right)), 1e-13);
        Vec3 du = vec3_sub(de_casteljau(control, u + h, v), de_casteljau(control, u - h, v)),
             dv = vec3_sub(de_casteljau(control, u, v + h), de_casteljau(control, u, v - h));
        cr_assert_lt(vec3_length(vec3_sub(at.du, vec3_scale(du, 0.5 / h))), 1e-7);
        cr_assert_lt(vec3_length(vec3_sub(at.dv, vec3_scale(dv, 0.5 / h))), 1e-7);
        cr_assert_lt(fabs(vec3_dot(at.normal, at.du)) + fabs(vec3_dot(at.normal, at.dv)), 1e-10);
        curved_patch_border(control, 1, border);
        Vec3 on = curved_curve_point(border, v);
        cr_assert_lt(vec3_length(vec3_sub(on, de_casteljau(control, 1, v))), 1e-13);
    }
}

// Proves that a border drawn together to a point has the normal that the patch has beside it, and that a lathe's quarter lies
// on its circles exactly.
Test(curved, lathe_is_round_and_has_normals_at_its_pole) {
    Arena arena = {0};
    Building b;
    curved_read_model(&arena, "lathe red 0,0 profile 0,0 0.2,0 0.4,0.1 0.5,0.4", "2,2", &b);
    cr_assert_eq(b.shape_count, 4);
    for (int i = 0; i < 4; i++) {
        const CurvedControl *control = b.controls + b.shapes[i].first_control;
        Vec3 n = curved_patch_at(control, 0.3, 0).normal;
        cr_expect_lt(vec3_length(vec3_sub(n, vec3(0, 0, -1))), 1e-9, "(%g, %g, %g)", n.x, n.y, n.z);
        for (int k = 0; k <= 10; k++) {
            Vec3 p = curved_patch_point(control, k / 10.0, 1), q = curved_patch_point(control, 0, 0.4),
                 r = curved_patch_point(control, k / 10.0, 0.4);
            cr_expect_float_eq(hypot(p.x - 2, p.y - 2), 0.5, 1e-14);
            cr_expect_float_eq(hypot(r.x - 2, r.y - 2), hypot(q.x - 2, q.y - 2), 1e-14);
        }
    }
    arena_free(&arena);
}

// ---- distances

// How far a point lies off a quadric, at most: by its own space, where an axis of length a is 1.
static double off_quadric(const CurvedShape *s, Vec3 p) {
    double c[3], longest = 0;
    Vec3 from = vec3_sub(p, s->frame.origin);
    for (int k = 0; k < 3; k++) {
        double square = vec3_dot(s->frame.axis[k], s->frame.axis[k]);
        c[k] = vec3_dot(from, s->frame.axis[k]) / square;
        if (k < 2 || s->kind == CURVED_SPHERE) longest = fmax(longest, sqrt(square));
    }
    if (s->kind == CURVED_SPHERE) return longest * fabs(sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]) - 1);
    double top = s->kind == CURVED_CONE ? s->top : 1, side = 1 + (top - 1) * c[2];
    double off = longest * fabs(hypot(c[0], c[1]) - side);
    double height = vec3_length(s->frame.axis[2]);
    for (int k = 0; k < 2; k++) {
        // Within a disc only its plane counts.
        if (s->disc[k] && hypot(c[0], c[1]) <= (k ? top : 1) + 1e-9) off = fmin(off, height * fabs(c[2] - k));
    }
    return off;
}

// The nearest point of a patch by steps of Gauss and Newton from the best of a grid.
static double off_patch(const CurvedControl *control, Vec3 p) {
    enum { GRID = 16, STEPS = 60 };
    double best = INFINITY, u = 0, v = 0;
    for (int i = 0; i <= GRID * GRID + 2 * GRID; i++) {
        double a = (double)(i % (GRID + 1)) / GRID, b = (double)(i / (GRID + 1)) / GRID;
        double far = vec3_length(vec3_sub(curved_patch_point(control, a, b), p));
        if (far < best) best = far, u = a, v = b;
    }
    for (int i = 0; i < STEPS; i++) {
        PatchPoint at = curved_patch_at(control, u, v);
        Vec3 r = vec3_sub(p, at.point);
        double a = vec3_dot(at.du, at.du) + 1e-14, b = vec3_dot(at.du, at.dv),
               c = vec3_dot(at.dv, at.dv) + 1e-14, x = vec3_dot(at.du, r), y = vec3_dot(at.dv, r),
               d = a * c - b * b;
        best = fmin(best, vec3_length(r));
        if (!(d > 0)) break;
        u = fmin(1, fmax(0, u + (c * x - b * y) / d));
        v = fmin(1, fmax(0, v + (a * y - b * x) / d));
    }
    return best;
}

static double off_shape(const Building *b, const CurvedShape *s, Vec3 p, double reach) {
    if (s->kind == CURVED_PATCH) return off_patch(b->controls + s->first_control, p);
    if (s->kind != CURVED_METABALLS) return off_quadric(s, p);
    Vec3 on = p;
    if (!curved_field_settle(b->balls + s->first_ball, s->ball_count, s->threshold, reach, &on))
        return INFINITY;
    return vec3_length(vec3_sub(on, p));
}

static void expect_on_shape(const Building *b, const CurvedShape *s, double tolerance, const char *what) {
    Arena arena = {0};
    CurvedMesh mesh;
    Random random = {7};
    curved_tessellate(b, s, tolerance, &arena, &mesh);
    cr_expect_leq(mesh.tolerance, tolerance + 1e-12, "%s: keeps %g of %g", what, mesh.tolerance, tolerance);
    // Patches are sought slowly: some of the polygons.
    int skip = s->kind == CURVED_PATCH ? 1 + mesh.polygon_count / 100 : 1;
    for (int i = 0; i < mesh.polygon_count; i += skip) {
        const Vec3 *v = mesh.vertices + mesh.first[i];
        int n = mesh.first[i + 1] - mesh.first[i];
        Plane plane = plane_of_polygon(v, n);
        cr_assert(n >= 3 && polygon_bend(v, n, plane) < 1e-8, "%s: polygon %d is bent", what, i);
        cr_assert(polygon_is_convex(v, n, plane.n), "%s: polygon %d is not convex", what, i);
        Vec3 inside = {0, 0, 0};
        double sum = 0;
        for (int k = 0; k < n; k++) {
            double off = off_shape(b, s, v[k], 1);
            cr_assert_lt(off, 1e-9, "%s: corner %d of %d lies %g off", what, k, i, off);
            double share = curved_between(&random, 0, 1);
            inside = vec3_add(inside, vec3_scale(v[k], share));
            sum += share;
        }
        double off = off_shape(b, s, vec3_scale(inside, 1 / sum), 1);
        cr_assert_leq(off, tolerance, "%s: polygon %d lies %g off (tolerance %g)", what, i, off, tolerance);
    }
}

// Proves that every corner lies on its shape, within a nanometre, and every polygon within the tolerance, which is used: with a
// tenth of it there are more.
Test(curved, polygons_lie_within_the_tolerance) {
    for (int c = 0; c < CLOSED_COUNT; c++) {
        Arena arena = {0};
        Building b;
        curved_read_model(&arena, CLOSED[c], "3,2 angle 35 mirror", &b);
        for (int i = 0; i < b.shape_count; i++) {
            expect_on_shape(&b, &b.shapes[i], 0.01, CLOSED[c]);
            expect_on_shape(&b, &b.shapes[i], 0.001, CLOSED[c]);
        }
        CurvedMesh coarse = curved_all(&b, 0.01, &arena), fine = curved_all(&b, 0.001, &arena);
        cr_expect_gt(fine.polygon_count, 2 * coarse.polygon_count, "%s: %d, %d", CLOSED[c],
                     coarse.polygon_count, fine.polygon_count);
        cr_expect_leq(fine.polygon_count, 40 * coarse.polygon_count, "%s: %d, %d", CLOSED[c],
                      coarse.polygon_count, fine.polygon_count);
        arena_free(&arena);
    }
}

// The same of patches as they come, whole.
Test(curved, any_patch_lies_within_the_tolerance) {
    Random random = {3};
    for (int n = 0; n < 12; n++) {
        CurvedControl control[PATCH_CONTROLS];
        curved_random_patch(&random, control);
        for (int i = 0; n % 3 == 0 && i < PATCH_CONTROLS; i++) {
            // A blister in a square: borders of a step, and a middle of many.
            bool inner = i % 4 % 3 != 0 && i / 4 % 3 != 0;
            control[i] = (CurvedControl){vec3(i % 4, i / 4, inner), 1};
        }
        Building b = {.controls = control};
        expect_on_shape(&b, &(CurvedShape){.kind = CURVED_PATCH}, n % 2 ? 0.05 : 0.02, "patch");
    }
}
