// test_shoot_direct.c - lamps shoot first, so that direct light is known; reflected light is gathered along rows.
#include <criterion/criterion.h>
#include <math.h>
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

// Reflected irradiance of a patch as its elements got it from shots, one channel.
static double shot_to(const Lit *lit, const RadSolution *s, int patch) {
    const Patch *p = &lit->mesh.patches[patch];
    double power = 0, rho = (double)mesh_material(&lit->mesh, p->face)->reflectance.g;
    for (int e = p->first_element; e < p->first_element + p->element_count; e++)
        power += lit->mesh.elements[e].area * (s->radiosity[e][1] - s->direct[e][1]);
    return power / (rho * p->area);
}

// How much the ratio to right light varies over the larger patches: what is seen as blotches.
static double scatter(const Lit *lit, const RadSolution *s, const RadSolution *right, bool gathered) {
    double sum = 0, squares = 0, area = 0;
    for (int p = 0; p < lit->mesh.patch_count; p++) {
        const Patch *patch = &lit->mesh.patches[p];
        if (mesh_emits(&lit->mesh, patch->face)) continue;
        double ratio = (gathered ? s->reflected[p][1] : shot_to(lit, s, p)) / right->reflected[p][1];
        sum += patch->area * ratio;
        squares += patch->area * ratio * ratio;
        area += patch->area;
    }
    return sqrt(squares / area - sum / area * sum / area) / (sum / area);
}

// Proves what gathering along rows is for: beside a lamp under a ceiling, whose light comes by way of a few square metres, the reflected
// light of patches scatters less about that of 600 lines of directions than what was shot to them by the same rows. At most four fifths as
// much: strong patches, whose rows have sixteen times as many samples, send the same light in both.
Test(shoot, reflected_light_is_gathered_along_rows, .timeout = 120) {
    Lit *lit = lit_new();
    lit_box(lit, vec3(0, 0, 0), vec3(6, 5, 2.6), true, LIT_WALL, 0);
    lit_quad(lit, vec3(1, 1, 2.3), vec3(1.3, 1, 2.3), vec3(1.3, 1.3, 2.3), vec3(1, 1.3, 2.3), LIT_LAMP);
    lit_finish(lit, 0.15, 1);
    RadOptions few = few_directions(), fine = few;
    RadSolution rough, truth;
    fine.form_factor.resolution = 600;
    lit_shoot(lit, &few, &rough);
    lit_shoot(lit, &fine, &truth);
    cr_assert(rough.gathered && truth.gathered);
    double gathered = scatter(lit, &rough, &truth, true), shot = scatter(lit, &rough, &truth, false);
    printf("gathered light scatters by %.3f %%, shot light by %.3f %%\n", 100 * gathered, 100 * shot);
    cr_expect_lt(gathered, 0.8 * shot);
    lit_free(lit);
}

// Proves the gathered light in closed form: in a furnace, a closed room of which all surfaces emit 1 and reflect a half, the radiosity is 2
// everywhere, and so 1 is reflected, twice of which arrives as 2 - 1. Tolerance: what is unshot.
Test(shoot, gathered_light_of_a_furnace) {
    Lit *lit = lit_new();
    lit_box(lit, vec3(0, 0, 0), vec3(3, 2, 2.5), true, LIT_WALL, 0);
    lit->building->materials[LIT_WALL].emission = (Rgb){1, 1, 1};
    lit->building->materials[LIT_WALL].reflectance = (Rgb){0.5f, 0.5f, 0.5f};
    lit_finish(lit, 0.5, 1);
    RadOptions options = few_directions();
    RadSolution s;
    options.residual = 1e-6;
    lit_shoot(lit, &options, &s);
    cr_assert(s.gathered);
    double sum = 0, area = 0;
    for (int p = 0; p < lit->mesh.patch_count; p++) {
        sum += lit->mesh.patches[p].area * s.reflected[p][0];
        area += lit->mesh.patches[p].area;
    }
    cr_expect_float_eq(sum / area, 1, 1e-3);
    lit_free(lit);
}

// Proves that gathered light is the same to the last bit on one thread and on three, and with no memory for rows.
Test(shoot, gathered_light_is_the_same_however_it_is_found) {
    Lit *lit = lit_rooms(1);
    RadOptions options = few_directions();
    RadSolution first, other;
    options.threads = 1;
    lit_shoot(lit, &options, &first);
    for (int i = 0; i < 2; i++) {
        options.threads = i == 0 ? 3 : 1;
        options.row_bytes = i == 0 ? options.row_bytes : 0;
        lit_shoot(lit, &options, &other);
        cr_assert(first.gathered && other.gathered);
        cr_expect_arr_eq(first.reflected, other.reflected,
                         (size_t)first.patch_count * sizeof *first.reflected);
    }
    lit_free(lit);
}
