// test_shoot_direct.c - lamps shoot first, so that direct light is known; patches beside lamps shoot in more directions.
#include <criterion/criterion.h>
#include <stdio.h>

#include "tests/support/lit_fixture.h"

static RadOptions few_directions(void) {
    RadOptions options = rad_default_options();
    options.form_factor.resolution = 50;
    options.residual = 1e-3;
    return options;
}

// Proves that `direct` is what lamps alone shoot, to the last bit, and stays so while reflected light is shot.
Test(shoot, direct_light_is_that_of_lamps_alone) {
    for (uint64_t seed = 1; seed <= 3; seed++) {
        Lit *lit = lit_rooms(seed);
        RadOptions options = few_directions(), lamps = options;
        RadSolution all, alone;
        lamps.lamps_only = true;
        lamps.residual = 0;
        lit_shoot(lit, &options, &all);
        lit_shoot(lit, &lamps, &alone);
        cr_assert_gt(all.shots, alone.shots);
        cr_assert_arr_eq(all.direct, alone.direct, (size_t)all.element_count * sizeof *all.direct);
        double most = 0;
        for (int e = 0; e < alone.element_count; e++) {
            double emitted[3];
            rgb_doubles(mesh_material(&lit->mesh, lit->mesh.elements[e].face)->emission, emitted);
            // Lamps shoot what they emit alone: what is left is direct. 1e-12: one rounding of the sum with the emission.
            for (int c = 0; c < 3; c++) {
                cr_assert_float_eq(alone.radiosity[e][c] - emitted[c], alone.direct[e][c],
                                   1e-12 * (1 + alone.radiosity[e][c]));
                most = fmax(most, alone.direct[e][c]);
            }
        }
        cr_assert_gt(most, 0);
        lit_free(lit);
    }
}

// Proves that a solution broken off after each number of shots, lamps' among them, and shot on is the same to the last bit.
Test(shoot, goes_on_among_lamps) {
    Lit *lit = lit_rooms(2);
    RadOptions options = few_directions();
    RadSolution whole, parts;
    options.shots = 60;
    lit_shoot(lit, &options, &whole);
    for (int first = 1; first < 12; first += 2) {
        options.shots = first;
        lit_shoot(lit, &options, &parts);
        cr_assert_eq(parts.shots, first);
        options.shots = 60;
        rad_shoot(&lit->mesh, &lit->forest, NULL, &options, NULL, &parts);
        size_t bytes = (size_t)whole.element_count * sizeof *whole.radiosity;
        cr_assert_arr_eq(whole.radiosity, parts.radiosity, bytes);
        cr_assert_arr_eq(whole.direct, parts.direct, bytes);
    }
    lit_free(lit);
}

// Root of the mean square difference of radiosities, over the mean.
static double difference(const Lit *lit, const RadSolution *a, const RadSolution *b) {
    double squares = 0, sum = 0, area = 0;
    for (int e = 0; e < a->element_count; e++) {
        double off = a->radiosity[e][1] - b->radiosity[e][1], size = lit->mesh.elements[e].area;
        if (mesh_emits(&lit->mesh, lit->mesh.elements[e].face)) continue;
        squares += size * off * off, sum += size * b->radiosity[e][1], area += size;
    }
    return sqrt(squares / area) / (sum / area);
}

// Proves what directions in proportion are for: beside a lamp under a ceiling, whose light comes by way of a few square metres, light is
// nearer to that of 600 lines of directions for the same number of samples. By a tenth at least: by theory it is a third.
Test(shoot, strong_patches_shoot_in_more_directions, .timeout = 120) {
    Lit *lit = lit_new();
    lit_box(lit, vec3(0, 0, 0), vec3(6, 5, 2.6), true, LIT_WALL, 0);
    lit_quad(lit, vec3(1, 1, 2.3), vec3(1.3, 1, 2.3), vec3(1.3, 1.3, 2.3), vec3(1, 1.3, 2.3), LIT_LAMP);
    lit_finish(lit, 0.15, 2);
    RadOptions even = few_directions(), fitted = even, fine = even;
    RadSolution solutions[3];
    even.fit_rows = false;
    fine.form_factor.resolution = 600;
    RadReport fitted_report = lit_shoot(lit, &fitted, &solutions[0]);
    RadReport even_report = lit_shoot(lit, &even, &solutions[1]);
    lit_shoot(lit, &fine, &solutions[2]);
    double off = difference(lit, &solutions[0], &solutions[2]),
           off_even = difference(lit, &solutions[1], &solutions[2]);
    printf("off by %.3f %%, with as many directions for all by %.3f %%\n", 100 * off, 100 * off_even);
    cr_expect_lt(off, 0.9 * off_even);
    cr_expect_lt(fitted_report.elements_drawn_mean, 1.2 * even_report.elements_drawn_mean);
    lit_free(lit);
}
