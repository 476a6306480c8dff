// test_form_factor_shapes.c - large polygons near by, sheets, overlaps and polygons through each other.
#include <criterion/criterion.h>

#include "radiosity/factors/analytic.h"
#include "tests/radiosity/factors/stability_fixture.h"
#include "tests/support/support.h"
#include "tests/support/view_fixture.h"

// ---- shapes that tempt

// The image of a large polygon near by is not convex on the disc: every sample sees what a ray sees. Chords of 1 degree are
// up to 4e-5 off.
Test(form_factor_stability, large_polygons_near_by) {
    EACH_METHOD(m) {
        if (!(*m)->projective) continue;
        int sure = 0, wrong = 0;
        Random random = {41};
        for (int n = 0; n < 40; n++) {
            Arena arena = {0};
            ViewFixture *f = view_fixture_new(&arena);
            ViewPose pose = view_fixture_pose(&random, vec3(0, 0, 0));
            Vec3 v[4];
            for (int k = 0; k < 4; k++)
                v[k] = view_fixture_place(&pose, vec3(k == 0 || k == 3 ? -3 : 2, k < 2 ? -4 : 5, 0.1));
            view_fixture_face(&arena, f, v, 4);
            View *view = view_fixture_look(&arena, f, vec3(0, 0, 0), vec3(0, 0, 1));
            FormFactor *maker = stability_maker_of(&arena, *m, f, 100);
            const FormFactorSamples *s = form_factor_samples(maker);
            const int32_t *item = form_factor_items(maker, view);
            for (int i = 0; i < s->count; i++) {
                Vec3 w = vec3((double)s->x[i], (double)s->y[i], (double)s->z[i]);
                int cast = view_fixture_cast(view, w, stability_as_printed(*m) ? 1e-4 : 1e-6);
                sure += cast != -2;
                wrong += cast != -2 && cast != item[i];
            }
            form_factor_end(maker);
            arena_free(&arena);
        }
        cr_log_info("%-20s large polygons from 0.1 m: %d of %d samples wrong", (*m)->name, wrong, sure);
        // Along the rim polylines have holes.
        cr_expect(wrong == 0 ||
                      ((stability_as_printed(*m) || stability_in_floats(*m)) && wrong < sure / 1000),
                  "%s, seed 41: %d of %d samples wrong", (*m)->name, wrong, sure);
    }
}

// A sheet that covers the eye, so near that thresholds swallow it; and two sheets as near each other.
static void check_sheets(const FormFactorMethod *method, double gap, Vec3 shift) {
    Arena arena = {0};
    ViewFixture *f = view_fixture_new(&arena);
    stability_slab(&arena, f, vec2(-1, -1), vec2(1, 1), gap, 0.3, shift);
    double seen = stability_share_at(&arena, method, f, 100, shift);
    ViewFixture *g = view_fixture_new(&arena);
    stability_slab(&arena, g, vec2(-1, -1), vec2(1, 1), 1, 0.3, shift);
    stability_slab(&arena, g, vec2(-1, -1), vec2(1, 1), 1 + gap, 0.3, shift);
    // As pixels have it without the second sheet.
    ViewFixture *h = view_fixture_new(&arena);
    stability_slab(&arena, h, vec2(-1, -1), vec2(1, 1), 1, 0.3, shift);
    double nearer = stability_share_at(&arena, method, g, 100, shift),
           alone = stability_share_at(&arena, method, h, 100, shift);
    cr_log_info("%-20s sheet %g m away, %g m from the origin: %.7f; of two so far apart %+.2g", method->name,
                gap, vec3_length(shift), seen, nearer - alone);
    if (!stability_in_floats(method) || gap > 1e-5)
        cr_expect(fabs(seen - 1) < 1e-3, "%s: sheet %g m away: %g", method->name, gap, seen);
    if (!stability_in_floats(method))
        cr_expect(fabs(nearer - alone) < 1e-6, "%s: sheets %g m apart: %g too little", method->name, gap,
                  alone - nearer);
    arena_free(&arena);
}

Test(form_factor_stability, sheets) {
    static const double GAP[] = {2e-7, 1e-6, 1e-4};
    EACH_METHOD(m)
    for (int i = 0; i < 3; i++) {
        check_sheets(*m, GAP[i], vec3(0, 0, 0));
        check_sheets(*m, GAP[i], vec3(600, -700, 400));
        check_sheets(*m, GAP[i], vec3(6e5, -7e5, 4e5));
    }
}

static double sum_of_two(Arena *arena, FormFactor *maker, const ViewFixture *f, bool reversed,
                         double share[2]) {
    View *view = view_fixture_look(arena, f, vec3(0, 0, 0), vec3(0, 0, 1));
    cr_assert_eq(view->face_count, 2);
    if (reversed) {
        ViewFace first = view->faces[0];
        view->faces[0] = view->faces[1];
        view->faces[1] = first;
    }
    const Row *row = form_factor_row(maker, view);
    for (int i = 0; i < 2; i++) share[i] = stability_share_of(&f->mesh, row, i);
    return share[0] + share[1];
}

// The lower one of coincident quads is seen, whole, whatever the order they are drawn in; turned, so that their planes
// are rounded.
Test(form_factor_stability, coplanar_overlap) {
    EACH_METHOD(m) {
        Random random = {61};
        for (int n = 0; n < 20; n++) {
            Arena arena = {0};
            ViewFixture *one = view_fixture_new(&arena), *two = view_fixture_new(&arena);
            double turn = random_between(&random, 0, 3);
            stability_slab(&arena, one, vec2(-.6, -.7), vec2(.8, .5), 1, turn, vec3(0, 0, 0));
            stability_slab(&arena, two, vec2(-.6, -.7), vec2(.8, .5), 1, turn, vec3(0, 0, 0));
            stability_slab(&arena, two, vec2(-.6, -.7), vec2(.8, .5), 1, turn, vec3(0, 0, 0));
            double alone = stability_share_at(&arena, *m, one, 100, vec3(0, 0, 0)), share[2], reversed[2];
            FormFactor *maker = stability_maker_of(&arena, *m, two, 100);
            double sum = sum_of_two(&arena, maker, two, false, share);
            sum_of_two(&arena, maker, two, true, reversed);
            form_factor_end(maker);
            cr_expect(fabs(sum - alone) < 1e-7, "%s, seed 61: two %.9f, one %.9f", (*m)->name, sum, alone);
            if (stability_in_floats(*m)) continue;
            cr_expect(share[1] == 0, "%s, seed 61: the upper face has %g", (*m)->name, share[1]);
            cr_expect(share[0] == reversed[0] && share[1] == reversed[1],
                      "%s, seed 61: the order shows: %g %g, %g %g", (*m)->name, share[0], share[1],
                      reversed[0], reversed[1]);
            arena_free(&arena);
        }
    }
}

// Quads that pass through each other, nearly parallel or not, near the eye: along a line one may dip behind another and come
// back. L1 to the exact row; tolerance by what edges cost a method at 400, for polylines none.
static double pierced(const FormFactorMethod *method, Random *random) {
    Arena arena = {0};
    ViewFixture *f = view_fixture_new(&arena);
    double bend = random_between(random, 0.02, 1);
    for (int i = 0; i < 4; i++) {
        Vec3 v[4];
        double height = random_between(random, 0.5, 1);
        const double at[4][2] = {{-4, -4}, {-4, 4}, {4, 4}, {4, -4}};
        Vec3 n = vec3_normalize(
            vec3(random_between(random, -bend, bend), random_between(random, -bend, bend), -1));
        for (int k = 0; k < 4; k++) {
            Vec3 p = vec3(at[k][0], at[k][1], 0);
            p.z = height - (n.x * p.x + n.y * p.y) / n.z;
            v[k] = p;
        }
        view_fixture_face(&arena, f, v, 4);
    }
    View *view = view_fixture_look(&arena, f, vec3(0, 0, 0), vec3(0, 0, 1));
    const Row *exact =
        form_factor_row(stability_maker_of(&arena, form_factor_method("analytic"), f, 400), view);
    FormFactor *maker = stability_maker_of(&arena, method, f, 400);
    const Row *row = form_factor_row(maker, view);
    double l1 = fabs(row->escaped - exact->escaped) + fabs(row->back - exact->back);
    for (int i = 0; i < 4; i++)
        l1 += fabs(stability_share_of(&f->mesh, row, i) - stability_share_of(&f->mesh, exact, i));
    form_factor_end(maker);
    arena_free(&arena);
    return l1;
}

Test(form_factor_stability, interpenetration, .timeout = 120) {
    EACH_METHOD(m) {
        Random random = {83};
        double worst = 0;
        for (int n = 0; n < 24; n++) worst = fmax(worst, pierced(*m, &random));
        cr_log_info("%-20s quads through each other: worst L1 %.2g", (*m)->name, worst);
        if (!stability_as_printed(*m))
            cr_expect(worst < ((*m)->projective || stability_fits(*m) ? 5e-3 : 1e-3), "%s, seed 83: L1 %.2g",
                      (*m)->name, worst);
    }
}
