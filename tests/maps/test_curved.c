// test_curved.c - curved shapes: points of patches, polygons within their tolerance, closed and of the right size, trims, and
// what is refused.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "engine/core/random.h"
#include "maps/curved/curved_field.h"
#include "maps/curved/curved_patch.h"
#include "tests/support/curved_fixture.h"
#include "tests/support/support.h"

// Closed shapes; a torus whose profile is four cubics; a vase with an inside that meets the axis at both ends.
static const char TORUS[] =
    "lathe red 0,0,0.3 profile 0.30,-0.1 0.3552,-0.1 0.4,-0.0552 0.4,0 0.4,0.0552 0.3552,0.1 "
    "0.3,0.1 0.2448,0.1 0.2,0.0552 0.2,0 0.2,-0.0552 0.2448,-0.1 0.30,-0.1";
static const char VASE[] =
    "lathe red 0,0 profile 0,0 0.03,0 0.05,0 0.06,0 0.06,0.01 0.14,0.1 0.04,0.2 0.05,0.3 "
    "0.045,0.305 0.04,0.3 0.03,0.2 0.12,0.12 0,0.02";
static const char *const CLOSED[] = {
    "sphere red 0,0,0.3 radius 0.3",
    "ellipsoid red 0,0,0.5 radii 0.1,0.3,0.5 angle 20",
    "cylinder red 0.1 0.9 0,0 radius 0.3 round",
    "cone red 0,0,0.1 0.4,0.2,0.6 radius 0.2",
    "cone red 0,0,0.1 0,0,0.6 radius 0.2 top 0.1",
    "cone red 0,0,0.1 0.2,0,0.6 radius 0.1 top 0.25",
    TORUS,
    VASE,
    "metaballs red threshold 0.5\nball 0,0,0.5 radius 0.5",
    "metaballs red threshold 0.4\nball 0,0,0.4 radius 0.4\nball 0.3,0,0.4 radius 0.3\n"
    "ball 0.1,0.1,0.6 radius 0.2 weight -0.4\nball 0.1,-0.2,0.5 radius 0.3"};
enum { CLOSED_COUNT = sizeof CLOSED / sizeof *CLOSED };

static double between(Random *random, double low, double high) { return random_between(random, low, high); }

static void random_patch(Random *random, CurvedControl control[PATCH_CONTROLS]) {
    for (int i = 0; i < PATCH_CONTROLS; i++) {
        Vec3 p = vec3(i % 4 + between(random, -0.3, 0.3), i / 4 + between(random, -0.3, 0.3),
                      between(random, -0.5, 0.5));
        control[i] = (CurvedControl){p, between(random, 0.3, 3)};
    }
}

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
        random_patch(&random, control);
        double u = between(&random, 0.01, 0.99), v = between(&random, 0.01, 0.99), h = 1e-5;
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
            double share = between(&random, 0, 1);
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
        random_patch(&random, control);
        for (int i = 0; n % 3 == 0 && i < PATCH_CONTROLS; i++) {
            // A blister in a square: borders of a step, and a middle of many.
            bool inner = i % 4 % 3 != 0 && i / 4 % 3 != 0;
            control[i] = (CurvedControl){vec3(i % 4, i / 4, inner), 1};
        }
        Building b = {.controls = control};
        expect_on_shape(&b, &(CurvedShape){.kind = CURVED_PATCH}, n % 2 ? 0.05 : 0.02, "patch");
    }
}

// ---- closed

// Proves that closed shapes are closed: each edge is there once each way, as made and as kept in the building, turned and
// mirrored; and that they face out: their volume is positive.
Test(curved, closed_shapes_are_watertight) {
    static const char *const PLACES[] = {"3,2", "3,2 angle 33 mirror"};
    static const double TOLERANCES[] = {0, 0.02, 0.003, 0.0004};
    for (int c = 0; c < CLOSED_COUNT; c++) {
        for (int p = 0; p < 2; p++) {
            for (int t = 0; t < 4; t++) {
                Arena arena = {0};
                Building b;
                curved_read_model(&arena, CLOSED[c], PLACES[p], &b);
                CurvedMesh mesh = curved_all(&b, TOLERANCES[t], &arena);
                int open = curved_open_edges(&mesh, &arena);
                cr_expect_eq(open, 0, "%s: %d open edges of %d polygons at %g", CLOSED[c], open,
                             mesh.polygon_count, TOLERANCES[t]);
                cr_expect_gt(curved_volume(&mesh), 0.0005, "%s: volume %g", CLOSED[c], curved_volume(&mesh));
                arena_free(&arena);
            }
        }
    }
}

// Random clusters of balls, some of which take away: closed and facing out too.
Test(curved, metaballs_are_watertight) {
    Random random = {5};
    for (int n = 0; n < support_count(40, 1000); n++) {
        Arena arena = {0};
        int count = 2 + n % 6;
        CurvedBall *balls = ARENA_ARRAY(&arena, CurvedBall, count);
        for (int i = 0; i < count; i++)
            balls[i] =
                (CurvedBall){vec3(between(&random, 0, 1), between(&random, 0, 1), between(&random, 0, 1)),
                             between(&random, 0.2, 0.6),
                             i && between(&random, 0, 1) < 0.3 ? -0.5 : between(&random, 0.6, 1.5)};
        Building b = {.balls = balls};
        CurvedShape shape = {.kind = CURVED_METABALLS, .ball_count = count, .threshold = 0.5};
        CurvedMesh mesh;
        curved_tessellate(&b, &shape, 0.01, &arena, &mesh);
        cr_expect_eq(curved_open_edges(&mesh, &arena), 0, "cluster %d", n);
        cr_expect(mesh.polygon_count == 0 || curved_volume(&mesh) > 0, "cluster %d", n);
        arena_free(&arena);
    }
}

// ---- sizes

// The radius at which the field of a ball of weight 1 is a half, by halving.
static double half_radius(double radius) {
    CurvedBall ball = {{0, 0, 0}, radius, 1};
    double low = 0, high = radius;
    for (int i = 0; i < 100; i++) {
        double middle = (low + high) / 2;
        *(curved_field(&ball, 1, vec3(middle, 0, 0)) > 0.5 ? &low : &high) = middle;
    }
    return low;
}

// Area and volume of what the torus's profile sweeps (Pappus), by Simpson's rule on its four cubics.
static void torus_size(double *area, double *volume) {
    static const double R[13] = {0.3, 0.3552, 0.4, 0.4, 0.4, 0.3552, 0.3, 0.2448, 0.2, 0.2, 0.2, 0.2448, 0.3},
                        Z[13] = {-0.1, -0.1,   -0.0552, 0,       0.0552, 0.1, 0.1,
                                 0.1,  0.0552, 0,       -0.0552, -0.1,   -0.1};
    enum { STEPS = 200 };
    *area = *volume = 0;
    for (int k = 0; k < 12; k += 3) {
        for (int i = 0; i <= STEPS; i++) {
            double t = (double)i / STEPS, s = 1 - t,
                   w = (i == 0 || i == STEPS ? 1
                        : i % 2              ? 4
                                             : 2) /
                       (3.0 * STEPS);
            double b[4] = {s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t},
                   d[4] = {-3 * s * s, 3 * s * (s - 2 * t), 3 * t * (2 * s - t), 3 * t * t}, r = 0, dr = 0,
                   dz = 0;
            for (int j = 0; j < 4; j++) {
                r += b[j] * R[k + j];
                dr += d[j] * R[k + j];
                dz += d[j] * Z[k + j];
            }
            *area += w * 2 * M_PI * r * hypot(dr, dz);
            *volume += w * M_PI * r * r * dz;
        }
    }
}

// Proves that area and volume come to those of the closed form, and in proportion to the tolerance: polygons within it lie
// inside, by up to it.
Test(curved, sizes_converge) {
    const double slope = hypot(0.4, 0.2), ball = half_radius(0.5);
    double torus[2];
    torus_size(&torus[0], &torus[1]);
    const struct {
        const char *shape;
        double area, volume;
    } CASES[] = {
        {CLOSED[0], 4 * M_PI * 0.09, 4 * M_PI * 0.027 / 3},
        {CLOSED[2], 2 * M_PI * 0.3 * 0.8 + 2 * M_PI * 0.09, M_PI * 0.09 * 0.8},
        {"cone red 0,0,0.1 0,0,0.5 radius 0.2", M_PI * 0.2 * slope + M_PI * 0.04, M_PI * 0.04 * 0.4 / 3},
        {TORUS, torus[0], torus[1]},
        {CLOSED[8], 4 * M_PI * ball * ball, 4 * M_PI * ball * ball * ball / 3}};
    for (size_t c = 0; c < sizeof CASES / sizeof *CASES; c++) {
        for (double tolerance = 0.01; tolerance > 0.0005; tolerance /= 4) {
            Arena arena = {0};
            Building b;
            curved_read_model(&arena, CASES[c].shape, "4,2 angle 70", &b);
            CurvedMesh mesh = curved_all(&b, tolerance, &arena);
            double area = curved_area(&mesh) / CASES[c].area - 1,
                   volume = curved_volume(&mesh) / CASES[c].volume - 1;
            // A shell as thick as the tolerance, against shapes of some 0.2 m; areas lose as much.
            cr_expect_lt(fabs(volume), 25 * tolerance, "%s: volume off by %g at %g", CASES[c].shape, volume,
                         tolerance);
            cr_expect_lt(fabs(area), 25 * tolerance, "%s: area off by %g at %g", CASES[c].shape, area,
                         tolerance);
            arena_free(&arena);
        }
    }
}

// ---- borders and trims

// Proves that two patches that share a border, one of them the other way round and with other curves elsewhere, meet in the
// same points at any tolerance.
Test(curved, neighbours_meet) {
    Random random = {11};
    for (int n = 0; n < 60; n++) {
        Arena arena = {0};
        CurvedControl control[2 * PATCH_CONTROLS];
        random_patch(&random, control);
        random_patch(&random, control + PATCH_CONTROLS);
        CurvedMesh mesh[2], both = {0};
        double tolerance = pow(10, between(&random, -3, -0.5));
        for (int k = 0; k < 2; k++) {
            // u = 1 of the first is u = 0 of the other, turned round.
            for (int j = 0; k == 1 && j < 4; j++) control[PATCH_CONTROLS + 4 * j] = control[4 * (3 - j) + 3];
            Building b = {.controls = control};
            CurvedShape shape = {.kind = CURVED_PATCH, .first_control = k * PATCH_CONTROLS};
            curved_tessellate(&b, &shape, tolerance, &arena, &mesh[k]);
            for (int i = 0; i < mesh[k].polygon_count; i++)
                curved_mesh_add(&both, &arena, mesh[k].vertices + mesh[k].first[i],
                                mesh[k].first[i + 1] - mesh[k].first[i], k == 1);
        }
        // Sides turned: the second faces the other way, else its border would run as the first's does.
        CurvedControl border[4];
        curved_patch_border(control, 1, border);
        int steps = curved_border_steps(border, tolerance),
            alone = curved_open_edges(&mesh[0], &arena) + curved_open_edges(&mesh[1], &arena);
        int open = curved_open_edges(&both, &arena);
        cr_expect_eq(open, alone - 2 * steps, "pair %d: %d open edges, %d apart, %d shared", n, open, alone,
                     steps);
        arena_free(&arena);
    }
}

// A square of side 1 with its whole outline as a trim, and a circle in it; the circle from four exact quarters.
static const char SQUARE[] =
    "patch red 0,0,1 0.3333,0,1 0.6667,0,1 1,0,1 0,0.3333,1 0.3333,0.3333,1 0.6667,0.3333,1 "
    "1,0.3333,1 0,0.6667,1 0.3333,0.6667,1 0.6667,0.6667,1 1,0.6667,1 0,1,1 0.3333,1,1 "
    "0.6667,1,1 1,1,1 tolerance 0.0005\n"
    "trim 0,0 0.3,0 0.6,0 1,0 1,0.3 1,0.6 1,1 0.6,1 0.3,1 0,1 0,0.6 0,0.3 0,0\n";

static char *circle(Arena *arena, double x, double y, double r) {
    const double half = sqrt(0.5), far = r * 2 * half / (1 + 2 * half), w = (1 + 2 * half) / 3;
    return arena_format(arena,
                        "trim %.15g,%.15g %.15g,%.15g %.15g,%.15g %.15g,%.15g %.15g,%.15g %.15g,%.15g "
                        "%.15g,%.15g %.15g,%.15g "
                        "%.15g,%.15g %.15g,%.15g %.15g,%.15g %.15g,%.15g %.15g,%.15g weights 1 %.15g %.15g 1 "
                        "%.15g %.15g 1 %.15g "
                        "%.15g 1 %.15g %.15g 1\n",
                        x + r, y, x + r, y + far, x + far, y + r, x, y + r, x - far, y + r, x - r, y + far,
                        x - r, y, x - r, y - far, x - far, y - r, x, y - r, x + far, y - r, x + r, y - far,
                        x + r, y, w, w, w, w, w, w, w, w);
}

// Proves that a trim leaves the area it should, also where loops lie in and beside one another, and that what is left has no
// gaps: open edges lie on the loops alone.
Test(curved, trims_leave_what_they_should) {
    Arena arena = {0};
    const char *hole = circle(&arena, 0.5, 0.5, 0.3), *core = circle(&arena, 0.5, 0.5, 0.1),
               *alone = circle(&arena, 0.37, 0.41, 0.33), *second = circle(&arena, 0.8, 0.85, 0.1);
    const struct {
        char *trims;
        double area;
    } CASES[] = {
        {arena_format(&arena, "%s%s", SQUARE, hole), 1 - M_PI * 0.09},
        {arena_format(&arena, "%s%s%s", SQUARE, hole, core), 1 - M_PI * 0.08},
        {arena_format(&arena, "%.*s%s%s", (int)(strchr(SQUARE, '\n') + 1 - SQUARE), SQUARE, alone, second),
         M_PI * (0.33 * 0.33 + 0.01)}};
    for (size_t c = 0; c < sizeof CASES / sizeof *CASES; c++) {
        for (int way = 0; way < 2; way++) {
            Building b;
            curved_read_model(&arena, CASES[c].trims, way ? "3,2 angle 40 mirror" : "3,2", &b);
            CurvedMesh mesh = curved_all(&b, 0, &arena);
            // Chords of a circle leave out up to 0.5 mm along its 2 m.
            cr_expect_float_eq(curved_area(&mesh), CASES[c].area, 0.002, "case %d: %g", (int)c,
                               curved_area(&mesh));
        }
    }
    arena_free(&arena);
}

static double off_loop(const CurvedTrim *loop, int count, Vec3 p) {
    enum { STEPS = 2000 };
    double least = INFINITY;
    for (int i = 0; i < count * STEPS; i++) {
        Vec2 at = curved_trim_point(&loop[i / STEPS], (double)(i % STEPS) / STEPS);
        least = fmin(least, hypot(at.x - p.x, at.y - p.y));
    }
    return least;
}

// Proves that bent patches within loops of any form have, from above, the area within the loop (by Green's theorem), and that
// open edges lie on it and nowhere else. Tolerance: chords of the loop lie off it by about that of the patch, 3 mm.
Test(curved, trimmed_patches_have_no_gaps) {
    Random random = {13};
    for (int n = 0; n < 40; n++) {
        Arena arena = {0};
        CurvedControl control[PATCH_CONTROLS];
        // Seen from above, parameters are places.
        for (int i = 0; i < PATCH_CONTROLS; i++)
            control[i] = (CurvedControl){vec3(i % 4 / 3.0, i / 4 / 3.0, between(&random, -0.2, 0.2)), 1};
        double x = between(&random, 0.35, 0.65), y = between(&random, 0.35, 0.65);
        CurvedTrim loop[3];
        Vec2 at[9];
        for (int i = 0; i < 9; i++) {
            double a = 2 * M_PI * i / 9, r = between(&random, 0.1, 0.34);
            at[i] = vec2(x + r * cos(a), y + r * sin(a));
        }
        for (int k = 0; k < 3; k++)
            for (int i = 0; i < 4; i++) loop[k].point[i] = at[(3 * k + i) % 9], loop[k].weight[i] = 1;
        Building b = {.controls = control, .trims = loop};
        CurvedShape shape = {.kind = CURVED_PATCH, .trim_count = 3};
        CurvedMesh mesh;
        curved_tessellate(&b, &shape, 0.003, &arena, &mesh);
        double within = 0;
        for (int k = 0; k < 3; k++) {
            for (int i = 0; i < 1000; i++) {
                Vec2 p = curved_trim_point(&loop[k], i / 1000.0),
                     q = curved_trim_point(&loop[k], (i + 1) / 1000.0);
                within += vec2_cross(p, q) / 2;
            }
        }
        Vec3 *ends;
        int open = curved_find_open(&mesh, &arena, &ends);
        cr_expect_gt(open, 10);
        for (int i = 0; i < 2 * open; i++) {
            double off = off_loop(loop, 3, ends[i]);
            cr_assert_lt(off, 0.006, "loop %d: an open edge ends at (%g, %g), %g off", n, ends[i].x,
                         ends[i].y, off);
        }
        double flat = 0;
        for (int i = 0; i < mesh.polygon_count; i++) {
            Vec3 v[32];
            int count = mesh.first[i + 1] - mesh.first[i];
            for (int k = 0; k < count; k++) {
                v[k] = mesh.vertices[mesh.first[i] + k];
                v[k].z = 0;
            }
            flat += polygon_area(v, count);
        }
        cr_expect_float_eq(flat, fabs(within), 0.003, "loop %d: %g of %g", n, flat, within);
        arena_free(&arena);
    }
}

// ---- what is refused

typedef struct Bad {
    const char *lines, *fragment;
} Bad;

static const char FOLDED[] =
    "patch red 0,0,0 2,0,0 -1,0,0 1,0,0 0,0.3,0 2,0.3,0 -1,0.3,0 1,0.3,0 0,0.6,0 2,0.6,0 "
    "-1,0.6,0 1,0.6,0 0,1,0 2,1,0 -1,1,0 1,1,0";
static const char LINE[] =
    "patch red 0,0,0 1,0,0 2,0,0 3,0,0 0,0,0 1,0,0 2,0,0 3,0,0 0,0,0 1,0,0 2,0,0 3,0,0 0,0,0 "
    "1,0,0 2,0,0 3,0,0";

// A loop of 80 curves all over the square.
static char *scribble(Arena *arena, int head) {
    Random random = {17};
    char *text = arena_format(arena, "%.*s\ntrim 0.5,0.5", head, SQUARE);
    for (int i = 1; i < 240; i++)
        text = arena_format(arena, "%s %.3f,%.3f", text, between(&random, 0, 1), between(&random, 0, 1));
    return arena_format(arena, "%s 0.5,0.5", text);
}

// Proves that bad shapes are refused with what is wrong and what is allowed.
Test(curved, faults_are_named) {
    Arena arena = {0};
    int head = (int)(strchr(SQUARE, '\n') - SQUARE);
    const char *weights = "1 1 1 1 1 1 1 1 1 1 1 1 1 1 1";
    const Bad BAD[] = {
        {"sphere red 0,0,1 radius 0", "radius is '0' (allowed: a number from 0.001 to 100 metres)"},
        {"sphere red 0,0,1", "radius is missing"},
        {"sphere red 0,0 radius 1", "the centre is '0,0'"},
        {"sphere red 0,0,1 radius 1 tolerance 0",
         "tolerance is '0' (allowed: a number from 1e-05 to 1 metres)"},
        {"sphere red 0,0,1 radius 90 tolerance 0.0001", "takes too many polygons"},
        {"ellipsoid red 0,0,1 radii 1,0,1",
         "radii is '1,0,1' (allowed: x,y,z, each from 0.001 to 100 metres)"},
        {"cylinder red 0 1 0,0 radius 1 sides 8 round", "sides that is round"},
        {"cylinder red 0 1 0,0 radius 1 tolerance 0.1", "a tolerance that is not round"},
        {"cylinder red 1 1 0,0 radius 1 round", "the cylinder has no height"},
        {"cone red 0,0,1 0,0,1 radius 1", "the cone is 0 metres high"},
        {"cone red 0,0,1 0,0,2 radius 0 top 1", "radius is '0'"},
        {"lathe red 0,0 profile 1,0 1,1 1,2", "the profile has 3 points r,z (allowed: 4, 7, 10"},
        {"lathe red 0,0 profile 1,0 1,1 1,2 -1,3", "point 4 of the profile has radius -1"},
        {"lathe red 0,0 profile 0,0 0,1 0,2 0,3", "part 1 of the profile lies on a line"},
        {"lathe red 0,0 profile 1,0 1,2 1,-1 1,1", "part 1 of the profile folds over itself near"},
        {FOLDED, "the patch folds over itself near u"},
        {LINE, "the patch lies on a line or in a point"},
        {"patch red 0,0,0 1,0,0", "the patch has 2 control points (allowed: 16"},
        {arena_format(&arena, "%.*s weights %s", head, SQUARE, weights),
         "the patch has 15 weights (allowed: 16"},
        {arena_format(&arena, "%.*s weights %s 0", head, SQUARE, weights), "weights is '0'"},
        {arena_format(&arena, "%.*s\ntrim 0,0 0.1,0 0.2,0 0.3,0.1", head, SQUARE),
         "begins at 0,0 and ends at 0.3,0.1"},
        {arena_format(&arena, "%.*s\ntrim 0,0 1.1,0 1,1 0,0", head, SQUARE), "point 2 of the trim is 1.1,0"},
        {arena_format(&arena, "%.*s\ntrim 0,0 1,0 1,1 0,1 0,0", head, SQUARE), "the trim has 5 points"},
        {arena_format(&arena, "%.*s\ntrim 0,0 1,1 1,1 0,0", head, SQUARE),
         "nothing of the shape can be seen"},
        {scribble(&arena, head), "the trims cut the patch into too many pieces"},
        {"box 0,0,0 1,1,1 red\ntrim 0,0 1,0 1,1 0,0", "a trim of nothing (allowed: behind a patch)"},
        {"ball 0,0,0 radius 1", "a ball of nothing"},
        {"metaballs red threshold 0.5", "the metaballs have no ball"},
        {"metaballs red threshold 0\nball 0,0,0 radius 1", "threshold is '0'"},
        {"metaballs red threshold 1.5\nball 0,0,0 radius 1\nball 3,0,0 radius 1",
         "the field of the metaballs reaches 1, their threshold is 1.5"},
        {"metaballs red threshold 0.5\nball 0,0,0 radius 1 weight 0", "the ball's weight is 0"},
        {"metaballs red threshold 0.5\nball 0,0,0 radius 0", "radius is '0'"}};
    for (size_t i = 0; i < sizeof BAD / sizeof *BAD; i++) {
        Building b;
        Error error = {""};
        cr_expect_not(curved_try_model(&arena, BAD[i].lines, "2,2", &b, &error), "was read: %s",
                      BAD[i].lines);
        cr_expect(strstr(error.text, BAD[i].fragment), "%s: '%s' should hold '%s'", BAD[i].lines, error.text,
                  BAD[i].fragment);
    }
    arena_free(&arena);
}
