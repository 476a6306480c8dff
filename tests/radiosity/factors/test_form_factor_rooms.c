// test_form_factor_rooms.c - rows in rooms: half hidden, closed, and nearer to the exact one with the resolution.
#include <criterion/criterion.h>

#include "radiosity/factors/analytic.h"
#include "tests/radiosity/factors/form_factor_fixture.h"
#include "tests/support/view_fixture.h"

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
    for (int k = 0; k < 4; k++)
        target[k] = form_factor_spun(target[k], angle), screen[k] = form_factor_spun(screen[k], angle);
    view_fixture_quad(&arena, f, target[0], target[1], target[2], target[3], 3, 2);
    view_fixture_quad(&arena, f, screen[0], screen[1], screen[2], screen[3], 1, 1);
    double mean = 0;
    if (s->shooter == 0)
        mean = form_factor_share(&arena, f, method, resolution, form_factor_spun(vec3(.5, .5, 0), angle));
    for (int k = 0; k < 144 && s->shooter > 0; k++) {
        int i = k % 12, j = k / 12;
        Vec3 eye = vec3((i / 6 + GAUSS_X[i % 6]) / 2, (j / 6 + GAUSS_X[j % 6]) / 2, 0);
        mean += GAUSS_W[i % 6] * GAUSS_W[j % 6] / 4 *
                form_factor_share(&arena, f, method, resolution, form_factor_spun(eye, angle));
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
                       bound = form_factor_tolerance(*m, RESOLUTION[r]);
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
        cr_expect(worst < form_factor_tolerance(*m, 400), "%s, seed 71: an element is off by %.2g",
                  (*m)->name, worst);
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

// ---- shifted samples

// A strip of ceiling 3 to 5 times as far away as it is high, seen from 16 sides: 7 samples of a row of 48 lines meet it, 112 of all shifts.
// Proves that samples shifted among neighbours err less in their sum, and that each shifted row sums to 1. Tolerance: some samples more or
// less at the strip's edges are a fifth of the light of one row, and 5 % of that of all.
Test(form_factor, shifted_samples_add_up) {
    enum { TURNS = 16 };
    const FormFactorMethod *method = form_factor_method("hemisphere"),
                           *right = form_factor_method("analytic");
    FormFactorOptions options = form_factor_default_options();
    options.resolution = 48;
    options.shifts = true;
    double worst[2] = {0};
    for (int k = 0; k < TURNS; k++) {
        Arena arena = {0};
        ViewFixture *f = view_fixture_new(&arena);
        Vec3 v[4] = {{3, -0.75, 1}, {3, 0.75, 1}, {5, 0.75, 1}, {5, -0.75, 1}};
        for (int i = 0; i < 4; i++) v[i] = form_factor_spun(v[i], 2 * M_PI * k / TURNS);
        view_fixture_face(&arena, f, v, 4);
        const View *view = view_fixture_look(&arena, f, vec3(0, 0, 0), vec3(0, 0, 1));
        double exact, found, sum = 0;
        spread(&f->mesh, form_factor_row(form_factor_new(right, &f->mesh, &options, &arena), view), &exact);
        FormFactor *maker = form_factor_new(method, &f->mesh, &options, &arena);
        for (int shift = 0; shift < FORM_FACTOR_SHIFTS; shift++) {
            const Row *row = form_factor_row_shifted(maker, view, shift);
            cr_expect_float_eq(row_total(row), 1, 1e-6, "shift %d: %.9g", shift, row_total(row));
            spread(&f->mesh, row, &found);
            worst[0] = fmax(worst[0], fabs(found / exact - 1));
            sum += found / FORM_FACTOR_SHIFTS;
        }
        worst[1] = fmax(worst[1], fabs(sum / exact - 1));
        form_factor_end(maker);
        arena_free(&arena);
    }
    cr_log_info("worst %.3f of one shift, %.3f of their mean", worst[0], worst[1]);
    cr_expect_gt(worst[0], 0.2);
    cr_expect_lt(worst[1], 0.05);
}
