// test_form_factor.c - every method against exact answers: closed forms of unoccluded and half-hidden polygons, closure of
// rooms, and the exact rows of furnished rooms.
#include <criterion/criterion.h>

#include "radiosity/factors/analytic.h"
#include "tests/radiosity/factors/form_factor_fixture.h"
#include "tests/support/view_fixture.h"

// ---- points

typedef struct Case {
    const char *name;
    Vec3 v[4];
    int count;
    double exact;
} Case;

#define FLOOR(x0, y0, x1, y1, h) {{x0, y0, h}, {x0, y1, h}, {x1, y1, h}, {x1, y0, h}}, 4

#define WALL(x, y0, y1, z0, z1) {{x, y0, z0}, {x, y0, z1}, {x, y1, z1}, {x, y1, z0}}, 4

// Closed forms, seen from the origin about the normal z.
static const Case CASES[] = {
    {"under a corner, h = 1", FLOOR(0, 0, 1, 1, 1), .13853160599},
    {"under the centre, h = 1", FLOOR(-.5, -.5, .5, .5, 1), .23945647046},
    {"under the centre, h = 0.1", FLOOR(-.5, -.5, .5, .5, .1), .96833955697},
    {"under the centre, h = 0.01", FLOOR(-.5, -.5, .5, .5, .01), .99967278694},
    {"middle of the foot, 1 away", WALL(1, -.5, .5, 0, 1), .07109343905},
    {"middle of the foot, 0.1 away", WALL(.1, -.5, .5, 0, 1), .42254486024},
    {"middle of the foot, 0.01 away", WALL(.01, -.5, .5, 0, 1), .49215895216},
    {"middle of the foot, 0.001 away", WALL(.001, -.5, .5, 0, 1), .49921579760},
    {"corner of the foot, 1 away", WALL(1, 0, 1, 0, 1), .05573419700},
    {"corner of the foot, 0.1 away", WALL(.1, 0, 1, 0, 1), .22173867087},
    {"corner of the foot, 0.01 away", WALL(.01, 0, 1, 0, 1), .24715860590},
    {"corner of the foot, 0.001 away", WALL(.001, 0, 1, 0, 1), .24971584521},
    {"triangle", {{1, 0, 1}, {-1, -1, 1.5}, {0, 1, 2}}, 3, .17805731486},
    {"wall through the horizon", WALL(1, -1, 1, -1, 1), .11146839401},
};

enum { CASE_COUNT = sizeof CASES / sizeof *CASES };

static double error_of(const FormFactorMethod *method, const Case *c, double angle, int resolution) {
    Arena arena = {0};
    ViewFixture *f = view_fixture_new(&arena);
    Vec3 v[4];
    for (int k = 0; k < c->count; k++) v[k] = form_factor_spun(c->v[k], angle);
    view_fixture_face(&arena, f, v, c->count);
    double error = form_factor_share(&arena, f, method, resolution, vec3(0, 0, 0)) - c->exact;
    arena_free(&arena);
    return fabs(error);
}

// Each polygon as it is, and turned so that nothing is aligned with pixels; the larger error counts. The mean error of
// the table at 400 is less than half of that at 100.
Test(form_factor, exact_table) {
    for (const FormFactorMethod *const *m = FORM_FACTOR_METHODS; *m; m++) {
        double mean[3] = {0};
        for (int r = 0; r < 3; r++) {
            double worst = 0, bound = form_factor_tolerance(*m, RESOLUTION[r]);
            for (int i = 0; i < CASE_COUNT; i++) {
                double error = fmax(error_of(*m, &CASES[i], 0, RESOLUTION[r]),
                                    error_of(*m, &CASES[i], 0.35, RESOLUTION[r]));
                worst = fmax(worst, error);
                mean[r] += error / CASE_COUNT;
                cr_expect(error <= bound, "%s %d, %s: off by %.2g (allowed %.2g)", (*m)->name, RESOLUTION[r],
                          CASES[i].name, error, bound);
            }
            cr_log_info("%-20s %4d: mean %.2g, worst %.2g of %.2g", (*m)->name, RESOLUTION[r], mean[r], worst,
                        bound);
        }
        cr_expect(mean[2] < fmax(mean[0] / 2, 1e-7), "%s: mean error %.2g at 100, %.2g at 400", (*m)->name,
                  mean[0], mean[2]);
    }
}

// The closed form itself, in doubles.
Test(form_factor, analytic_points) {
    for (int i = 0; i < CASE_COUNT; i++) {
        double f = analytic_point(CASES[i].v, CASES[i].count);
        cr_expect(fabs(f - CASES[i].exact) < 1e-10, "%s: %.12f", CASES[i].name, f);
    }
    // Disks as polygons of many corners: their lack of area, 2 pi^2 / (3 n^2) of it, is 2.5e-5.
    static const double DISK[][2] = {{1, .5}, {.1, .99009900990}};
    for (int i = 0; i < 2; i++) {
        Vec3 disk[512];
        for (int k = 0; k < 512; k++) disk[k] = vec3(cos(M_PI * k / 256), sin(M_PI * k / 256), DISK[i][0]);
        double f = analytic_point(disk, 512);
        cr_expect(fabs(f - DISK[i][1]) < 2.6e-5, "disk at %g: %.12f", DISK[i][0], f);
    }
}

// ---- pairs

typedef struct Pair {
    const char *name;
    Vec3 a[4], b[4];
    double exact;  // from a to b
} Pair;

#define SQUARE(x, y)                                                                                         \
    {                                                                                                        \
        {0, 0, 0}, {x, 0, 0}, {x, y, 0}, { 0, y, 0 }                                                         \
    }

#define UPRIGHT(y, h)                                                                                        \
    {                                                                                                        \
        {0, 0, 0}, {0, y, 0}, {0, y, h}, { 0, 0, h }                                                         \
    }

static const Pair PAIRS[] = {
    {"parallel squares, 10", SQUARE(1, 1), ABOVE(1, 1, 10), .00316205684},
    {"parallel squares, 1", SQUARE(1, 1), ABOVE(1, 1, 1), .19982489570},
    {"parallel squares, 0.5", SQUARE(1, 1), ABOVE(1, 1, .5), .41525328358},
    {"parallel squares, 0.1", SQUARE(1, 1), ABOVE(1, 1, .1), .82699452240},
    {"parallel squares, 0.01", SQUARE(1, 1), ABOVE(1, 1, .01), .98041660293},
    {"parallel squares, 0.001", SQUARE(1, 1), ABOVE(1, 1, .001), .99800563191},
    {"parallel 1 x 2, 0.5", SQUARE(2, 1), ABOVE(2, 1, .5), .50898866904},
    {"perpendicular 1:1", SQUARE(1, 1), UPRIGHT(1, 1), .20004377608},
    {"perpendicular h = 2", SQUARE(1, 1), UPRIGHT(1, 2), .23285260280},
    {"perpendicular w = 0.1", SQUARE(.1, 1), UPRIGHT(1, 1), .43251369401},
    {"perpendicular h = 0.1", SQUARE(1, 1), UPRIGHT(1, .1), .04325136940},
    {"perpendicular edge 4", SQUARE(3, 4), UPRIGHT(4, 2.5), .20352467630},
};

enum { PAIR_COUNT = sizeof PAIRS / sizeof *PAIRS };

// The table to its last digit; and reciprocity, which holds to the last bit.
Test(form_factor, analytic_pairs) {
    for (int i = 0; i < PAIR_COUNT; i++) {
        const Pair *p = &PAIRS[i];
        double there = analytic_exchange(p->a, 4, p->b, 4), back = analytic_exchange(p->b, 4, p->a, 4);
        double f = there / polygon_area(p->a, 4);
        cr_expect(fabs(f - p->exact) < 1.1e-11, "%s: %.12f", p->name, f);
        cr_expect(there == back, "%s: A F is %.17g and %.17g", p->name, there, back);
    }
}

// Random pairs against the mean of the point formula over either polygon. Tolerance: the quadrature's, for polygons some
// distance apart.
Test(form_factor, analytic_pairs_as_means_of_points) {
    Random random = {5};
    for (int n = 0; n < 50; n++) {
        ViewPose pose = view_fixture_pose(&random, vec3(0.3, -0.2, 3));
        Vec3 a[4] = SQUARE(1, 1), b[4];
        for (int k = 0; k < 4; k++) b[k] = view_fixture_place(&pose, vec3(a[k].x, 1.5 * a[k].y, 0));
        Plane front = plane_of_polygon(b, 4);
        if (plane_distance(front, vec3(0.5, 0.5, 0)) < 0)
            for (int k = 0; k < 2; k++) {
                Vec3 c = b[k];
                b[k] = b[3 - k], b[3 - k] = c;
            }
        double mean = 0;
        bool before = true;
        front = plane_of_polygon(b, 4);
        for (int k = 0; k < 4; k++) before &= plane_distance(front, a[k]) > 0;
        if (!before) continue;
        for (int k = 0; k < 36; k++) {
            Vec3 eye = vec3(GAUSS_X[k % 6], GAUSS_X[k / 6], 0), v[4];
            for (int i = 0; i < 4; i++) v[i] = vec3_sub(b[i], eye);
            mean += GAUSS_W[k % 6] * GAUSS_W[k / 6] * analytic_point(v, 4);
        }
        double f = analytic_exchange(a, 4, b, 4);
        cr_expect(fabs(f - mean) < 1e-9, "seed 5, pair %d: %.12f, mean of points %.12f", n, f, mean);
    }
}
