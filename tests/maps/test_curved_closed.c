// test_curved_closed.c - the polygons of closed shapes are watertight, and areas and volumes converge.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "engine/core/random.h"
#include "maps/curved/curved_field.h"
#include "tests/maps/curved_shapes.h"
#include "tests/support/curved_fixture.h"
#include "tests/support/support.h"

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
            balls[i] = (CurvedBall){
                vec3(curved_between(&random, 0, 1), curved_between(&random, 0, 1),
                     curved_between(&random, 0, 1)),
                curved_between(&random, 0.2, 0.6),
                i && curved_between(&random, 0, 1) < 0.3 ? -0.5 : curved_between(&random, 0.6, 1.5)};
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
