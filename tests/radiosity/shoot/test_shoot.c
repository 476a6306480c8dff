// test_shoot.c - what shooting promises: no power is lost, none gets through walls, and the same bytes come out however the
// work is divided.
#include <criterion/criterion.h>
#include <unistd.h>

#include "radiosity/shoot/shoot_queue.h"
#include "tests/radiosity/shoot/shoot_fixture.h"
#include "tests/support/lit_fixture.h"

// Proves the energy balance through everything: in a closed room that emits 1 W/m^2 and reflects half everywhere, B = 2.
// Single elements miss it by what shooting from centres costs; their mean does not, since rows sum to 1.
Test(shoot, furnace_has_radiosity_two) {
    Lit *lit = lit_new();
    lit->building->materials[LIT_WALL].emission = (Rgb){1, 1, 1};
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    lit_finish(lit, 0.5, 1);
    RadOptions options = shoot_options_to(1e-9);
    RadSolution s;
    lit_shoot(lit, &options, &s);
    double sum = 0, area = 0, square = 0;
    for (int e = 0; e < s.element_count; e++) {
        double a = lit->mesh.elements[e].area, b = s.radiosity[e][1];
        sum += a * b;
        square += a * (b - 2) * (b - 2);
        area += a;
    }
    // Tolerance: floats of single shares, 6e-8, and the residual.
    cr_assert_float_eq(sum / area, 2, 1e-6, "mean of B is %.9f", sum / area);
    cr_assert_lt(sqrt(square / area), 0.06, "RMS of B is %.4f", sqrt(square / area));
    cr_assert_eq(s.escaped[0], 0);
    lit_free(lit);
}

static Lit *furnished(int mask) {
    Lit *lit = lit_new();
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, mask);
    lit_lamp(lit, vec3(2, 1.5, 2.4));
    lit_box(lit, vec3(0.5, 0.4, 0.01), vec3(1.2, 1.3, 0.8), false, LIT_RED, 0);
    // A sheet, whose back swallows light.
    lit_quad(lit, vec3(3, 1, 0.5), vec3(3, 2, 0.5), vec3(3, 2, 1.5), vec3(3, 1, 1.5), LIT_RED);
    lit_finish(lit, 0.4, 2);
    return lit;
}

// Proves emitted = absorbed + escaped + unshot, channel by channel, at any moment: closed, and with a wall missing.
Test(shoot, loses_no_power) {
    for (int mask = 0; mask < 2; mask++) {
        Lit *lit = furnished(mask);
        static const double RESIDUALS[] = {0.9, 0.3, 0.01, 1e-6};
        for (int i = 0; i < 4; i++) {
            RadOptions options = shoot_options_to(RESIDUALS[i]);
            RadSolution s;
            RadReport report = lit_shoot(lit, &options, &s);
            cr_assert_lt(shoot_lost_power(lit, &s), 1e-12, "%g of the power is lost",
                         shoot_lost_power(lit, &s));
            cr_assert_leq(report.residual, RESIDUALS[i]);
            cr_assert(mask ? s.escaped[0] > 0.01 * s.emitted[0] : s.escaped[0] == 0);
            cr_assert_gt(s.absorbed[0], 0);
        }
        lit_free(lit);
    }
}

// Proves that shooting ends when its shooters had so many faces before them: in a room of one cell each has all faces, so that so many
// shots are done as the limit holds all faces, the same shots as without it, and no power is lost.
Test(shoot, ends_when_faces_were_looked_at) {
    static const int SHOTS[] = {1, 5, 40};
    Lit *lit = lit_new();
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    lit_lamp(lit, vec3(2, 1.5, 2.4));
    lit_finish(lit, 0.4, 2);
    for (int i = 0; i < 3; i++) {
        for (int more = 0; more < 2; more++) {
            RadOptions options = shoot_options_to(1e-9), counted = shoot_options_to(1e-9);
            options.looks = lit->mesh.face_count * SHOTS[i] + (more ? lit->mesh.face_count - 1 : 0);
            counted.shots = SHOTS[i];
            RadSolution s, same;
            lit_shoot(lit, &options, &s);
            lit_shoot(lit, &counted, &same);
            cr_expect_eq(s.shots, SHOTS[i], "%lld shots, not %d", s.shots, SHOTS[i]);
            cr_expect_arr_eq(s.radiosity, same.radiosity, (size_t)s.element_count * sizeof *s.radiosity);
            cr_expect_lt(shoot_lost_power(lit, &s), 1e-12, "%g of the power is lost",
                         shoot_lost_power(lit, &s));
        }
    }
    lit_free(lit);
}

// Proves that what nobody asked for is fitted to the mesh, in more directions the fewer patches there are, and what was asked for stays.
Test(shoot, fits_what_is_left_open) {
    static const int PATCHES[] = {1, 4000, 4001, 10000, 10001, 1000000};
    double residual = 0;
    int resolution = 1 << 20;
    for (int i = 0; i < 6; i++) {
        Mesh mesh = {.patch_count = PATCHES[i]};
        for (int asked = 0; asked < 4; asked++) {
            RadOptions o = rad_default_options();
            o.residual = asked & 1 ? 0.5 : 0;
            o.form_factor.resolution = asked & 2 ? 17 : 0;
            rad_fit(&mesh, &o);
            cr_expect(asked & 1 ? o.residual == 0.5
                                : o.residual >= residual && o.residual > 0 && o.residual <= 1e-4);
            cr_expect(asked & 2 ? o.form_factor.resolution == 17
                                : o.form_factor.resolution <= resolution && o.form_factor.resolution >= 48);
            if (asked == 0) residual = o.residual, resolution = o.form_factor.resolution;
        }
    }
    cr_expect(residual == 1e-4 && resolution == 48);
}

// Proves that the report counts what was done: shots by their solution, a row for each shot where none is kept, fewer where they
// are, and of all faces and elements no more than there are.
Test(shoot, reports_what_was_done) {
    Lit *lit = furnished(0);
    for (int kept = 0; kept < 2; kept++) {
        RadOptions options = shoot_options_to(1e-4);
        options.threads = 1;
        options.row_bytes = kept ? (size_t)1 << 26 : 0;
        RadSolution s;
        RadReport report = lit_shoot(lit, &options, &s);
        cr_expect(report.shots == s.shots && report.shots > lit->mesh.patch_count);
        cr_expect(kept ? report.rows_made < report.shots && report.rows_made >= report.rows_kept &&
                             report.rows_kept > 0
                       : report.rows_made >= report.shots && report.rows_kept == 0,
                  "%lld shots, %lld rows, %lld kept", report.shots, report.rows_made, report.rows_kept);
        cr_expect(report.faces_drawn_mean > 1 && report.faces_drawn_mean <= lit->mesh.face_count, "%g",
                  report.faces_drawn_mean);
        cr_expect(kept ? report.row_bytes > 0 : report.row_bytes == 0);
    }
    lit_free(lit);
}

// Proves that no light leaks into a sealed room beside a lit one: exactly 0 everywhere, by every method, culled and not,
// with a wall of 10 cm between them, and with two walls in one plane. There a dark ceiling ends on the lit wall: of what is as
// near, floats cannot tell which is seen (Embree's do not), and the depths of polylines are wrong.
Test(shoot, sealed_room_stays_dark) {
    static const double GAPS[] = {0.1, 0};
    for (int g = 0; g < 2; g++) {
        Lit *lit = lit_new();
        double x = 3 + GAPS[g];
        lit_box(lit, vec3(x, -0.37, -0.2), vec3(x + 2.3, 2.11, 2.2), true, LIT_RED, 0);
        int dark = lit->building->polygon_count;
        lit_box(lit, vec3(0, 0, 0), vec3(3, 3, 2.5), true, LIT_WALL, 0);
        lit_lamp(lit, vec3(1.5, 1.5, 2.4));
        lit_finish(lit, 0.5, 2);
        for (int m = 0; FORM_FACTOR_METHODS[m]; m++) {
            if (GAPS[g] == 0 && FORM_FACTOR_METHODS[m]->truth != FORM_FACTOR_EXACT) continue;
            for (int culling = 0; culling < CULLINGS; culling++) {
                RadOptions options = shoot_options_to(0.02);
                RadSolution s;
                options.method = FORM_FACTOR_METHODS[m];
                options.culling = (Culling)culling;
                lit_shoot(lit, &options, &s);
                double lit_power = 0;
                for (int e = 0; e < s.element_count; e++) {
                    const Face *face = &lit->mesh.faces[lit->mesh.elements[e].face];
                    double power = s.radiosity[e][0] + s.radiosity[e][1] + s.radiosity[e][2];
                    if (face->polygon >= dark) lit_power += power * lit->mesh.elements[e].area;
                    cr_assert(face->polygon >= dark || power == 0,
                              "%s, culling %s, gap %g: %g W/m^2 in the dark", options.method->name,
                              CULLING_NAMES[culling], GAPS[g], power);
                }
                cr_assert_gt(lit_power, 1);
            }
        }
        lit_free(lit);
    }
}

// Proves that memory for rows grows with large meshes, by 8 kB for each element beyond 120,000, stays within the machine's, and that a
// given memory stays as it is.
Test(shoot, memory_for_rows_fits_the_mesh) {
    Mesh mesh = {.element_count = 120000, .patch_count = 40000};
    RadOptions options = rad_default_options();
    options.row_bytes = RAD_ROWS_FIT;
    rad_fit(&mesh, &options);
    size_t eighth = (size_t)sysconf(_SC_PHYS_PAGES) * (size_t)sysconf(_SC_PAGESIZE) / 8,
           usual = (size_t)512 << 20 < eighth ? (size_t)512 << 20 : eighth,
           more = usual + 80000000 < eighth ? usual + 80000000 : eighth;
    cr_expect_eq(options.row_bytes, usual);
    mesh.element_count = 130000;
    options.row_bytes = RAD_ROWS_FIT;
    rad_fit(&mesh, &options);
    cr_expect_eq(options.row_bytes, more);
    mesh.element_count = INT32_MAX;
    options.row_bytes = RAD_ROWS_FIT;
    rad_fit(&mesh, &options);
    cr_expect_leq(options.row_bytes, eighth);
    options.row_bytes = 5;
    rad_fit(&mesh, &options);
    cr_expect_eq(options.row_bytes, 5);
}
