// test_shoot.c - what shooting promises: no power is lost, none gets through walls, and the same bytes come out however the
// work is divided.
#include <criterion/criterion.h>

#include "radiosity/shoot/shoot_queue.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

static RadOptions options_to(double residual) {
    RadOptions o = rad_default_options();
    o.form_factor.resolution = 50;
    o.residual = residual;
    o.threads = 2;
    return o;
}

// Relative difference of emitted and absorbed + escaped + unshot, the worst channel.
static double lost_power(const Lit *lit, const RadSolution *s) {
    double worst = 0;
    for (int c = 0; c < 3; c++) {
        double unshot = 0;
        for (int p = 0; p < s->patch_count; p++) unshot += s->unshot[p][c] * lit->mesh.patches[p].area;
        double lost = s->emitted[c] - s->absorbed[c] - s->escaped[c] - unshot;
        worst = fmax(worst, fabs(lost) / s->emitted[c]);
    }
    return worst;
}

// Proves the energy balance through everything: in a closed room that emits 1 W/m^2 and reflects half everywhere, B = 2.
// Single elements miss it by what shooting from centres costs; their mean does not, since rows sum to 1.
Test(shoot, furnace_has_radiosity_two) {
    Lit *lit = lit_new();
    lit->building->materials[LIT_WALL].emission = (Rgb){1, 1, 1};
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    lit_finish(lit, 0.5, 1);
    RadOptions options = options_to(1e-9);
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
            RadOptions options = options_to(RESIDUALS[i]);
            RadSolution s;
            RadReport report = lit_shoot(lit, &options, &s);
            cr_assert_lt(lost_power(lit, &s), 1e-12, "%g of the power is lost", lost_power(lit, &s));
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
            RadOptions options = options_to(1e-9), counted = options_to(1e-9);
            options.looks = lit->mesh.face_count * SHOTS[i] + (more ? lit->mesh.face_count - 1 : 0);
            counted.shots = SHOTS[i];
            RadSolution s, same;
            lit_shoot(lit, &options, &s);
            lit_shoot(lit, &counted, &same);
            cr_expect_eq(s.shots, SHOTS[i], "%lld shots, not %d", s.shots, SHOTS[i]);
            cr_expect_arr_eq(s.radiosity, same.radiosity, (size_t)s.element_count * sizeof *s.radiosity);
            cr_expect_lt(lost_power(lit, &s), 1e-12, "%g of the power is lost", lost_power(lit, &s));
        }
    }
    lit_free(lit);
}

// Proves that what nobody asked for is fitted to the mesh, finer the fewer patches there are, and what was asked for stays.
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
                                : o.residual >= residual && o.residual > 0 && o.residual <= 1e-3);
            cr_expect(asked & 2 ? o.form_factor.resolution == 17
                                : o.form_factor.resolution <= resolution && o.form_factor.resolution >= 80);
            if (asked == 0) residual = o.residual, resolution = o.form_factor.resolution;
        }
    }
    cr_expect(residual == 1e-3 && resolution == 80);
}

// Proves that the report counts what was done: shots by their solution, a row for each shot where none is kept, fewer where they
// are, and of all faces and elements no more than there are.
Test(shoot, reports_what_was_done) {
    Lit *lit = furnished(0);
    for (int kept = 0; kept < 2; kept++) {
        RadOptions options = options_to(1e-4);
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
                RadOptions options = options_to(0.02);
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

static Bytes save(Lit *lit, const RadSolution *s) {
    Error error = {""};
    const char *path = arena_format(&lit->arena, "%s/x.rad", support_folder(&lit->arena));
    cr_assert(rad_save(path, &lit->mesh, NULL, s, &error), "%s", error.text);
    return support_read(&lit->arena, path);
}

static void expect_same(Bytes a, Bytes b, const char *what, long long number) {
    cr_assert_eq(a.size, b.size);
    cr_assert(memcmp(a.data, b.data, a.size) == 0, "the .rad file is another with %s %lld", what, number);
}

// Proves that the .rad file depends on nothing but building, mesh and method: not on threads, on the memory for rows, or
// on culling.
Test(shoot, is_the_same_however_it_is_done, .timeout = 300) {
    Lit *lit = lit_rooms(5);
    RadOptions options = options_to(0.02);
    RadSolution s;
    options.threads = 1;
    RadReport report = lit_shoot(lit, &options, &s);
    cr_assert_gt(report.shots, report.rows_made, "nobody shot twice: the rows' memory is not tried");
    Bytes first = save(lit, &s);
    static const int THREADS[] = {2, 7};
    static const size_t MEMORY[] = {0, 1 << 20, 100 << 20};
    for (int t = 0; t < 2; t++) {
        for (int m = 0; m < 3; m++) {
            options.threads = THREADS[t];
            options.row_bytes = MEMORY[m];
            report = lit_shoot(lit, &options, &s);
            cr_assert_leq(report.row_bytes, MEMORY[m]);
            expect_same(first, save(lit, &s), "threads", THREADS[t]);
        }
    }
    for (int culling = 0; culling < CULLINGS; culling++) {
        options.culling = (Culling)culling;
        lit_shoot(lit, &options, &s);
        expect_same(first, save(lit, &s), "culling", culling);
    }
    lit_free(lit);
}

static bool stop_at_once(void *context, const char *stage, double done) {
    int *calls = context;
    (void)stage;
    cr_assert(done >= 0 && done <= 1);
    return ++*calls < 4;
}

// Proves that a run that was broken off - by a number of shots, by the caller - is a valid solution, and that
// going on from its file ends in the same bytes as never having stopped.
Test(shoot, goes_on_where_it_stopped) {
    Lit *lit = lit_rooms(8);
    RadOptions options = options_to(1e-6);
    RadSolution straight, s;
    options.shots = 1500;
    lit_shoot(lit, &options, &straight);
    cr_assert_eq(straight.shots, 1500);
    Error error = {""};
    const char *path = arena_format(&lit->arena, "%s/x.rad", support_folder(&lit->arena));
    cr_assert(rad_start(&lit->mesh, &lit->arena, &s, &error));
    for (int part = 0; part < 4; part++) {
        int calls = 0;
        Progress progress = {stop_at_once, &calls};
        options.threads = part + 1;
        options.shots = part == 0 ? 333 : part == 1 ? 700 : 1500;
        RadReport report =
            rad_shoot(&lit->mesh, &lit->forest, NULL, &options, part == 2 ? &progress : NULL, &s);
        cr_assert_eq(report.stopped, part == 2);
        cr_assert_lt(lost_power(lit, &s), 1e-12);
        cr_assert(rad_save(path, &lit->mesh, NULL, &s, &error), "%s", error.text);
        cr_assert(rad_load(path, &lit->mesh, NULL, &lit->arena, &s, &error), "%s", error.text);
        if (part < 3) cr_assert_lt(s.shots, 1500);
    }
    expect_same(save(lit, &straight), save(lit, &s), "shots", s.shots);
    int calls = 3;
    Progress at_once = {stop_at_once, &calls};
    options.shots = 0;
    cr_assert(rad_shoot(&lit->mesh, &lit->forest, NULL, &options, &at_once, &s).stopped);
    cr_assert_eq(s.shots, 1500);
    lit_free(lit);
}

// Proves that what is no light is refused with a sentence.
Test(shoot, refuses_what_gives_no_light) {
    static const struct {
        int material;
        float reflectance, emission;
        const char *expected;
    } CASES[] = {{LIT_LAMP, 0, 0, "nothing emits light"},
                 {LIT_WALL, 1, 0, "reflectance 1 (allowed: at least 0, below 1)"},
                 {LIT_WALL, -0.1f, 0, "reflectance -0.1"},
                 {LIT_WALL, NAN, 0, "reflectance nan"},
                 {LIT_LAMP, 0, -3, "exitance -3 W/m^2"},
                 {LIT_LAMP, 0, INFINITY, "exitance inf"}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Lit *lit = lit_new();
        lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
        lit_lamp(lit, vec3(2, 1.5, 2.4));
        float rho = CASES[i].reflectance, e = CASES[i].emission;
        lit->building->materials[CASES[i].material].reflectance = (Rgb){rho, rho, rho};
        lit->building->materials[CASES[i].material].emission = (Rgb){e, e, e};
        lit_finish(lit, 1, 2);
        RadSolution s;
        Error error = {""};
        cr_assert_not(rad_start(&lit->mesh, &lit->arena, &s, &error));
        cr_assert_not_null(strstr(error.text, CASES[i].expected), "says `%s`", error.text);
        lit_free(lit);
    }
}

// Proves the queue against a plain search, with many ties: the strongest, and the strongest of those not taken, lowest
// index first.
Test(shoot, queue_is_a_plain_search) {
    for (uint64_t seed = 1; seed <= 20; seed++) {
        Random random = {seed};
        Arena arena = {0};
        ShootQueue queue;
        int count = 1 + random_index(&random, seed % 2 ? 300 : 9000);
        shoot_queue_start(&queue, count, &arena);
        bool *taken = ARENA_ARRAY(&arena, bool, count);
        cr_assert_eq(shoot_queue_top(&queue), -1);
        for (int i = 0; i < 2000; i++) {
            int patch = random_index(&random, count);
            taken[random_index(&random, count)] ^= true;
            if (random_unit(&random) < 0.2)
                shoot_queue_clear(&queue, patch);
            else
                shoot_queue_raise(&queue, patch, queue.power[patch] + random_index(&random, 4));
            int best = -1, next[5], found = shoot_queue_next(&queue, taken, 2, 5, next);
            for (int p = 0; p < count; p++)
                if (queue.power[p] > (best < 0 ? 0 : queue.power[best])) best = p;
            cr_assert_eq(shoot_queue_top(&queue), best, "seed %llu", (unsigned long long)seed);
            for (int k = 0; k < 5; k++) {
                int wanted = -1;
                for (int p = 0; p < count; p++) {
                    bool before = false;
                    for (int j = 0; j < k && j < found; j++) before = before || next[j] == p;
                    if (taken[p] || before || queue.power[p] < 2) continue;
                    if (wanted < 0 || queue.power[p] > queue.power[wanted]) wanted = p;
                }
                // The next strongest is among those found: it is moved to the front of what is left of them.
                int at = k;
                while (at < found && next[at] != wanted) at++;
                cr_assert(wanted < 0 ? k >= found : at < found, "seed %llu", (unsigned long long)seed);
                if (wanted >= 0) next[at] = next[k], next[k] = wanted;
            }
        }
        arena_free(&arena);
    }
}
