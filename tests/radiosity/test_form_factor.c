// test_form_factor.c - every method against exact answers: closed forms of unoccluded and half-hidden polygons, closure of
// rooms, and the exact rows of furnished rooms.
#include <criterion/criterion.h>

#include "radiosity/factors/analytic.h"
#include "tests/support/view_fixture.h"

static const int RESOLUTION[] = {100, 200, 400};

// How wrong a method may be, of a polygon turned any way: `pixels` / resolution. An edge that runs along a line of pixels
// errs by half a pixel times its length, others by less; the sliver over a wall 1 mm away, 0.0008 of all, is less
// than half a pixel even at 400. Scan lines of one way still see it whole. `least` is what the row's floats leave.
typedef struct Tolerance {
    const char *method;
    double pixels, least;
} Tolerance;

static const Tolerance TOLERANCES[] = {
    {"hemisphere", 0.4, 2e-7},
    {"hemicube", 0.4, 2e-7},
    {"hemisphere-scanline", 0.2, 2e-7},
    {"hemisphere-scanlines", 0.2, 2e-7},
    {"hemisphere-scanlines-fit", 0.8, 2e-7},  // of a quarter of the lines
    {"hemisphere-polyline", 0.4, 2e-7},
    {"analytic", 0, 2e-7},
    {"ray", 0.4, 2e-7},
    {"ray-disc", 0.4, 2e-7},
    {"ray-hemicube", 0.4, 2e-7},
};

static double tolerance(const FormFactorMethod *method, int resolution) {
    for (size_t i = 0; i < sizeof TOLERANCES / sizeof *TOLERANCES; i++) {
        const Tolerance *t = &TOLERANCES[i];
        if (strcmp(t->method, method->name) == 0) return t->least + t->pixels / resolution;
    }
    cr_assert_fail("no tolerance is stated for method %s", method->name);
    return 0;
}

// ---- points

typedef struct Case {
    const char *name;
    Vec3 v[4];
    int count;
    double exact;
} Case;

#define FLOOR(x0, y0, x1, y1, h) {{x0, y0, h}, {x0, y1, h}, {x1, y1, h}, {x1, y0, h}}, 4
#define WALL(x, y0, y1, z0, z1) {{x, y0, z0}, {x, y0, z1}, {x, y1, z1}, {x, y1, z0}}, 4

// references.md, seen from the origin about the normal z.
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

static Vec3 spun(Vec3 p, double angle) {
    return vec3(cos(angle) * p.x - sin(angle) * p.y, sin(angle) * p.x + cos(angle) * p.y, p.z);
}

// The share of all light that meets the front of the fixture's face 0 from the origin about z.
static double share(Arena *arena, const ViewFixture *f, const FormFactorMethod *method, int resolution,
                    Vec3 eye) {
    FormFactorOptions options = form_factor_default_options();
    options.resolution = resolution;
    FormFactor *maker = form_factor_new(method, &f->mesh, &options, arena);
    const Row *row = form_factor_row(maker, view_fixture_look(arena, f, eye, vec3(0, 0, 1)));
    double sum = 0;
    for (int i = 0; i < row->count; i++)
        if (f->mesh.elements[row->element[i]].face == 0) sum += (double)row->factor[i];
    form_factor_end(maker);
    return sum;
}

static double error_of(const FormFactorMethod *method, const Case *c, double angle, int resolution) {
    Arena arena = {0};
    ViewFixture *f = view_fixture_new(&arena);
    Vec3 v[4];
    for (int k = 0; k < c->count; k++) v[k] = spun(c->v[k], angle);
    view_fixture_face(&arena, f, v, c->count);
    double error = share(&arena, f, method, resolution, vec3(0, 0, 0)) - c->exact;
    arena_free(&arena);
    return fabs(error);
}

// Each polygon as it is, and turned so that nothing is aligned with pixels; the larger error counts. The mean error of
// the table at 400 is less than half of that at 100.
Test(form_factor, exact_table) {
    for (const FormFactorMethod *const *m = FORM_FACTOR_METHODS; *m; m++) {
        double mean[3] = {0};
        for (int r = 0; r < 3; r++) {
            double worst = 0, bound = tolerance(*m, RESOLUTION[r]);
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
#define ABOVE(x, y, h)                                                                                       \
    {                                                                                                        \
        {0, 0, h}, {0, y, h}, {x, y, h}, { x, 0, h }                                                         \
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

// Gauss-Legendre of six points over [0, 1].
static const double GAUSS_X[6] = {0.033765242898423989, 0.16939530676686774, 0.38069040695840156,
                                  0.61930959304159849,  0.83060469323313224, 0.96623475710157603};
static const double GAUSS_W[6] = {0.085662246189585178, 0.18038078652406929, 0.23395696728634552,
                                  0.23395696728634552,  0.18038078652406929, 0.085662246189585178};

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

// ---- half hidden

typedef struct Screened {
    const char *name;
    double shooter, x0,
        x1;  // shooter: side, 0 a point under the centre; the screen's corners (x0, x0), (x1, x1)
    double exact;
} Screened;

static const Screened SCREENED[] = {
    {"point, 0.25 screen", 0, .375, .625, .16597883565},
    {"squares, 0.5 screen centred", 1, .25, .75, .0995062946},
    {"squares, 0.5 screen in the corner", 1, 0, .5, .1498686718},
};

// The mean over the shooter in 2 x 2 panels, whose borders are where the shadow's edges leave the square: the shadow of a
// screen half-way has no other kinks.
static double screened(const FormFactorMethod *method, const Screened *s, int resolution, double angle) {
    Arena arena = {0};
    ViewFixture *f = view_fixture_new(&arena);
    Vec3 target[4] = ABOVE(1, 1, 1);
    Vec3 screen[4] = {{s->x0, s->x0, .5}, {s->x0, s->x1, .5}, {s->x1, s->x1, .5}, {s->x1, s->x0, .5}};
    for (int k = 0; k < 4; k++) target[k] = spun(target[k], angle), screen[k] = spun(screen[k], angle);
    view_fixture_quad(&arena, f, target[0], target[1], target[2], target[3], 3, 2);
    view_fixture_quad(&arena, f, screen[0], screen[1], screen[2], screen[3], 1, 1);
    double mean = 0;
    if (s->shooter == 0) mean = share(&arena, f, method, resolution, spun(vec3(.5, .5, 0), angle));
    for (int k = 0; k < 144 && s->shooter > 0; k++) {
        int i = k % 12, j = k / 12;
        Vec3 eye = vec3((i / 6 + GAUSS_X[i % 6]) / 2, (j / 6 + GAUSS_X[j % 6]) / 2, 0);
        mean += GAUSS_W[i % 6] * GAUSS_W[j % 6] / 4 * share(&arena, f, method, resolution, spun(eye, angle));
    }
    arena_free(&arena);
    return mean;
}

Test(form_factor, screens, .timeout = 120) {
    for (const FormFactorMethod *const *m = FORM_FACTOR_METHODS; *m; m++)
        for (int r = 0; r < 3; r++)
            for (int i = 0; i < 3; i++) {
                if (SCREENED[i].shooter > 0 && RESOLUTION[r] > 100) continue;  // 144 rows say enough
                double f = screened(*m, &SCREENED[i], RESOLUTION[r], 0.35),
                       bound = tolerance(*m, RESOLUTION[r]);
                double error = fabs(f - SCREENED[i].exact);
                cr_expect(error <= bound, "%s %d, %s: off by %.2g (allowed %.2g)", (*m)->name, RESOLUTION[r],
                          SCREENED[i].name, error, bound);
                cr_log_info("%-20s %4d %s: %.2g of %.2g", (*m)->name, RESOLUTION[r], SCREENED[i].name, error,
                            bound);
            }
}

// ---- rooms

static double row_total(const Row *row) {
    double sum = row->back + row->escaped;
    for (int i = 0; i < row->count; i++) sum += (double)row->factor[i];
    return sum;
}

// Rows of closed rooms sum to 1, and nothing escapes; polylines have holes along the rim (see form_factor_stability).
Test(form_factor, closure) {
    Random random = {11};
    for (int n = 0; n < 20; n++) {
        Arena arena = {0};
        ViewFixture *f = view_fixture_room(&arena, &random, 1 + n % 4, n / 2, vec3(0, 0, 0));
        View *view = view_fixture_look_about(&arena, f, &random);
        for (const FormFactorMethod *const *m = FORM_FACTOR_METHODS; *m; m++) {
            FormFactorOptions options = form_factor_default_options();
            FormFactor *maker = form_factor_new(*m, &f->mesh, &options, &arena);
            const Row *row = form_factor_row(maker, view);
            double holes = (*m)->truth == FORM_FACTOR_GUESS ? 1e-3 : 0;
            cr_expect(fabs(row_total(row) - 1) < 1e-6, "%s, seed 11, room %d: sum %.9f", (*m)->name, n,
                      row_total(row));
            cr_expect(row->escaped <= holes, "%s, seed 11, room %d: %g escaped", (*m)->name, n, row->escaped);
            form_factor_end(maker);
        }
        arena_free(&arena);
    }
}

static void spread(const Mesh *mesh, const Row *row, double *into) {
    for (int i = 0; i < mesh->element_count; i++) into[i] = 0;
    for (int i = 0; i < row->count; i++) into[row->element[i]] = (double)row->factor[i];
}

// Which element of a grid: each against Lambert's formula of its own corners. Parallelograms near and far, through the
// horizon, seen from both sides; on the disc the lines of their grids are curves that turn.
static double grid_error(const FormFactorMethod *method, Random *random) {
    Arena arena = {0};
    ViewFixture *f = view_fixture_new(&arena);
    ViewPose pose = view_fixture_pose(random, vec3(0, 0, random_between(random, 0.2, 1)));
    Vec3 a = view_fixture_place(&pose, vec3(-2, -1, 0)), b = view_fixture_place(&pose, vec3(2, -1.5, 0)),
         d = view_fixture_place(&pose, vec3(-1, 2, 0));
    view_fixture_quad(&arena, f, a, b, vec3_add(b, vec3_sub(d, a)), d, 7, 5);
    FormFactorOptions options = form_factor_default_options();
    options.resolution = 400;
    FormFactor *maker = form_factor_new(method, &f->mesh, &options, &arena);
    View *view = view_fixture_look(&arena, f, vec3(0, 0, 0), vec3(0, 0, 1));
    double *found = ARENA_ARRAY(&arena, double, f->mesh.element_count), worst = 0;
    spread(&f->mesh, form_factor_row(maker, view), found);
    for (int e = 0; e < f->mesh.element_count; e++) {
        Vec3 p[4];
        for (int k = 0; k < 4; k++) {
            Vec3 q = f->mesh.vertices[f->mesh.corners[f->mesh.elements[e].first_corner + k]];
            p[k] = vec3(vec3_dot(view->x, q), vec3_dot(view->y, q), vec3_dot(view->z, q));
        }
        double exact = f->mesh.faces[0].plane.d < 0 ? analytic_point(p, 4) : 0;
        worst = fmax(worst, fabs(found[e] - exact));
    }
    form_factor_end(maker);
    arena_free(&arena);
    return worst;
}

Test(form_factor, elements_of_a_grid) {
    for (const FormFactorMethod *const *m = FORM_FACTOR_METHODS; *m; m++) {
        Random random = {71};
        double worst = 0;
        for (int n = 0; n < 15; n++) worst = fmax(worst, grid_error(*m, &random));
        cr_log_info("%-20s elements of a grid at 400: worst %.2g", (*m)->name, worst);
        cr_expect(worst < tolerance(*m, 400), "%s, seed 71: an element is off by %.2g", (*m)->name, worst);
    }
}

// Under a sheet that covers all both ways agree at once, and the fewest lines do, 25 each way: the sheet's element and three
// stretches, with what passes under its ends. In
// furnished rooms lines are added until every single row is right: to what the two ways may differ, 60 / resolution^1.5.
Test(form_factor, lines_as_many_as_a_row_needs) {
    const FormFactorMethod *fit = form_factor_method("hemisphere-scanlines-fit");
    FormFactorOptions options = form_factor_default_options();
    Arena arena = {0};
    ViewFixture *sheet = view_fixture_new(&arena);
    view_fixture_face(&arena, sheet, (Vec3[]){{-1, -1, 1e-6}, {-1, 1, 1e-6}, {1, 1, 1e-6}, {1, -1, 1e-6}}, 4);
    FormFactor *maker = form_factor_new(fit, &sheet->mesh, &options, &arena);
    form_factor_row(maker, view_fixture_look(&arena, sheet, vec3(0, 0, 0), vec3(0, 0, 1)));
    cr_assert_leq(form_factor_work(maker).samples, 2 * 25 * 4, "%lld pieces",
                  form_factor_work(maker).samples);
    Random random = {29};
    double worst[2] = {0};
    for (int n = 0; n < 12; n++) {
        ViewFixture *f = view_fixture_room(&arena, &random, 3, n, vec3(0, 0, 0));
        View *view = view_fixture_look_about(&arena, f, &random);
        double *exact = ARENA_ARRAY(&arena, double, f->mesh.element_count),
               *found = ARENA_ARRAY(&arena, double, f->mesh.element_count);
        spread(&f->mesh,
               form_factor_row(form_factor_new(form_factor_method("analytic"), &f->mesh, &options, &arena),
                               view),
               exact);
        for (int r = 0; r < 2; r++) {
            options.resolution = r ? 200 : 50;
            spread(&f->mesh, form_factor_row(form_factor_new(fit, &f->mesh, &options, &arena), view), found);
            double l1 = 0;
            for (int i = 0; i < f->mesh.element_count; i++) l1 += fabs(exact[i] - found[i]);
            worst[r] = fmax(worst[r], l1);
            cr_expect(l1 < 60 / pow(options.resolution, 1.5), "seed 29, room %d: L1 %g at %d", n, l1,
                      options.resolution);
        }
    }
    cr_log_info("lines as many as a row needs: worst L1 %.2g at 50, %.2g at 200", worst[0], worst[1]);
    arena_free(&arena);
}

// Hidden faces get no share: the L1 distance of each method's row to the exact one, the mean over furnished rooms, falls
// as resolution grows. Polylines are held to less: their depth is wrong.
Test(form_factor, rows_converge_to_the_exact_one) {
    for (const FormFactorMethod *const *m = FORM_FACTOR_METHODS; *m; m++) {
        double mean[2] = {0};
        for (int r = 0; r < 2; r++) {
            Random random = {23};
            for (int n = 0; n < 12; n++) {
                Arena arena = {0};
                ViewFixture *f = view_fixture_room(&arena, &random, 3, 6, vec3(0, 0, 0));
                View *view = view_fixture_look_about(&arena, f, &random);
                FormFactorOptions options = form_factor_default_options();
                options.resolution = r ? 400 : 100;
                double *exact = ARENA_ARRAY(&arena, double, f->mesh.element_count),
                       *found = ARENA_ARRAY(&arena, double, f->mesh.element_count);
                spread(&f->mesh,
                       form_factor_row(
                           form_factor_new(form_factor_method("analytic"), &f->mesh, &options, &arena), view),
                       exact);
                FormFactor *maker = form_factor_new(*m, &f->mesh, &options, &arena);
                spread(&f->mesh, form_factor_row(maker, view), found);
                for (int i = 0; i < f->mesh.element_count; i++) mean[r] += fabs(exact[i] - found[i]) / 12;
                form_factor_end(maker);
                arena_free(&arena);
            }
        }
        cr_log_info("%-20s L1 %.2g at 100, %.2g at 400", (*m)->name, mean[0], mean[1]);
        bool wrong_depth = (*m)->truth == FORM_FACTOR_GUESS;
        cr_expect(wrong_depth || mean[1] < 1e-6 || mean[1] < mean[0] / 2.5, "%s: L1 %g at 100, %g at 400",
                  (*m)->name, mean[0], mean[1]);
        cr_expect(mean[1] < (wrong_depth ? 0.1 : 0.02), "%s: L1 %g at 400", (*m)->name, mean[1]);
    }
}
