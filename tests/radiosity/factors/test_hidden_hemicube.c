// test_hidden_hemicube.c - hidden-surface methods fill the sides of a hemicube.
#include <criterion/criterion.h>
#include <string.h>

#include "radiosity/factors/form_factor.h"
#include "tests/support/view_fixture.h"
#include "visibility/hidden/hidden.h"

enum { MOST = 1024 };

static void shares_of(const ViewFixture *f, const View *view, const char *hidden, double share[MOST]) {
    Arena arena = {0};
    FormFactorOptions options = form_factor_default_options();
    options.resolution = 64;
    options.hidden = hidden;
    FormFactor *rows = form_factor_new(form_factor_method("hemicube"), &f->mesh, &options, &arena);
    const Row *row = form_factor_row(rows, view);
    memset(share, 0, MOST * sizeof *share);
    for (int i = 0; i < row->count; i++) share[row->element[i]] = (double)row->factor[i];
    form_factor_end(rows);
    arena_free(&arena);
}

// In furnished rooms, turned and shifted, every exact method gives the row that the ray caster gives, bit by bit, and those in
// floats the same but for a few samples at edges: of 64 x 64 x 3, each at most 1/1000 of the row.
Test(hidden_hemicube, rows_are_the_same, .timeout = 60) {
    Random random = {11};
    for (int trial = 0; trial < 6; trial++) {
        Arena arena = {0};
        Vec3 shift = vec3_scale(vec3(3, -2, 1), trial);
        ViewFixture *f = view_fixture_room(&arena, &random, 2, 4, shift);
        View *view = view_fixture_look_about(&arena, f, &random);
        cr_assert_leq(f->mesh.element_count, MOST);
        double right[MOST], got[MOST];
        shares_of(f, view, "raycast", right);
        for (int m = 0; HIDDEN_METHODS[m]; m++) {
            if (HIDDEN_METHODS[m]->truth == HIDDEN_GUESS) continue;
            bool exact = HIDDEN_METHODS[m]->truth == HIDDEN_EXACT;
            shares_of(f, view, HIDDEN_METHODS[m]->name, got);
            double l1 = 0;
            for (int e = 0; e < f->mesh.element_count; e++) l1 += fabs(got[e] - right[e]);
            cr_assert(l1 <= (exact ? 0 : 5e-3), "%s, trial %d: L1 %g", HIDDEN_METHODS[m]->name, trial, l1);
        }
        arena_free(&arena);
    }
}
