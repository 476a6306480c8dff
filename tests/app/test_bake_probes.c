// test_bake_probes.c - the light at given points: of the reference scenes, where two random-walk programs agree, and at
// points whose light is known beforehand; and how points are read.
#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/app/bake_probes.h"
#include "maps/maps.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

// Largest and mean difference to the reference, relative.
typedef struct Differences {
    double most, mean;
    int count;
} Differences;

static Lit *read_lit(const char *path, double element) {
    Lit *lit = lit_new();
    Error error = {""};
    *lit->building = (Building){0};
    cr_assert(maps_read(path, &lit->arena, lit->building, &error), "%s", error.text);
    lit_finish(lit, element, 2);
    return lit;
}

static double expected_irradiance(Arena *arena, const char *name, const char *own, int point) {
    Bytes text = support_read(arena, support_either(arena_format(arena, "radiosity/%s.ref", name),
                                                    arena_format(arena, "tests/seeds/%s.ref", own)));
    for (char *line = strtok((char *)text.data, "\n"); line; line = strtok(NULL, "\n")) {
        double h;
        if (sscanf(line, "%*[^# ] %*f %*f %lf", &h) == 1 && point-- == 0) return h;
    }
    cr_assert_fail("%s.ref has too few points", name);
    return 0;
}

static Differences differences(const char *name, const char *own, double element) {
    Arena arena = {0};
    const char *path = support_either(arena_format(&arena, "radiosity/%s.quads", name),
                                      arena_format(&arena, "tests/seeds/%s.quads", own));
    path = arena_string(&arena, path);
    Lit *lit = read_lit(path, element);
    RadOptions options = rad_default_options();
    options.residual = 1e-4;
    RadSolution solution;
    lit_shoot(lit, &options, &solution);
    Probes probes = {0};
    Error error = {""};
    cr_assert(bake_probes_read(path, &arena, &probes, &error), "%s", error.text);
    bake_probes_gather(&(GatherScene){&lit->mesh, &lit->forest, NULL, &solution, NULL}, 1, &probes);
    Differences d = {.count = probes.count};
    for (int i = 0; i < probes.count; i++) {
        double h = expected_irradiance(&arena, name, own, i);
        double off = fabs(probes.probes[i].irradiance[1] / h - 1);
        d.most = fmax(d.most, off);
        d.mean += off / probes.count;
    }
    printf("%s, elements of %g m: %d points off by %.2f %% at most, %.2f %% in the mean\n", name, element,
           probes.count, 100 * d.most, 100 * d.mean);
    lit_free(lit);
    arena_free(&arena);
    return d;
}

// Proves that the light is right: in a room with two boxes. Tolerances are what elements of a third of a metre, constant and
// shot from the middle of 2 x 2, cost today (4.0 and 0.7 %), and that finer ones are better (0.3 and 0.1 %).
Test(bake_probes, box_with_two_boxes) {
    Differences coarse = differences("boxA", "boxes", 0.33), fine = differences("boxA", "boxes", 0.12);
    cr_assert_eq(coarse.count, 15);
    cr_assert(coarse.most < 0.04 && coarse.mean < 0.012);
    cr_assert(fine.most < 0.01 && fine.mean < 0.003);
}

// And through a doorway, into a room that is lit by it alone: 0.9 and 0.2 % today, and 0.4 and 0.1 %.
Test(bake_probes, two_rooms) {
    Differences coarse = differences("twoRoom", "two-rooms", 0.33),
                fine = differences("twoRoom", "two-rooms", 0.12);
    cr_assert_eq(coarse.count, 12);
    cr_assert(coarse.most < 0.04 && coarse.mean < 0.008);
    cr_assert(fine.most < 0.015 && fine.mean < 0.004);
}

// Proves H against closed forms: below a lamp of exitance (12, 10, 6) that nothing reflects; and B = E + rho H on a face,
// 0 on none.
Test(bake_probes, closed_forms) {
    Lit *lit = lit_new();
    lit->building->materials[LIT_WALL].reflectance = (Rgb){0, 0, 0};
    lit->building->materials[LIT_RED].reflectance = (Rgb){0.5f, 0.25f, 0.125f};
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 1 << 4);
    lit_quad(lit, vec3(0, 0, 0), vec3(4, 0, 0), vec3(4, 3, 0), vec3(0, 3, 0), LIT_RED);
    lit_lamp(lit, vec3(2, 1.5, 2));
    lit_finish(lit, 0.5, 2);
    RadOptions options = rad_default_options();
    RadSolution solution;
    // Just the lamp's own light: nothing is shot.
    options.residual = 1;
    lit_shoot(lit, &options, &solution);
    Arena arena = {0};
    Probes probes = {0};
    Error error = {""};
    static const char *const POINTS[] = {"2,1.5,1,0,0,1", "1.5 1 1 0 0 2", "2,1.5,0,0,0,1", "2,1.5,2,0,0,-1",
                                         "2,1.5,1,0,0,-1"};
    for (int i = 0; i < 5; i++)
        cr_assert(bake_probe_parse(POINTS[i], &arena, &probes, &error), "%s", error.text);
    bake_probes_gather(&(GatherScene){&lit->mesh, &lit->forest, NULL, &solution, NULL}, 1, &probes);
    const Probe *p = probes.probes;
    // A point under the centre and under a corner of a unit square, 1 m below, in closed form.
    cr_assert_float_eq(p[0].irradiance[0], 12 * .23945647046, 1e-6);
    cr_assert_float_eq(p[1].irradiance[1], 10 * .13853160599, 1e-6);
    cr_assert_eq(p[0].radiosity[0], 0);
    // 2 m below, by the closed form of the corner of a square of side 1/2, four times.
    double x = 0.25, y = 0.25, a = x / sqrt(1 + x * x), b = y / sqrt(1 + x * x);
    double f = 4 * (a * atan(b) + a * atan(b)) / (2 * M_PI);
    cr_assert_float_eq(p[2].irradiance[2], 6 * f, 1e-6, "%.9f, not %.9f", p[2].irradiance[2], 6 * f);
    cr_assert_float_eq(p[2].radiosity[0], 0.5 * p[2].irradiance[0], 1e-12);
    cr_assert_float_eq(p[2].radiosity[2], 0.125 * p[2].irradiance[2], 1e-12);
    cr_assert_eq(p[3].radiosity[1], 10);
    cr_assert_eq(p[4].irradiance[0], 0);
    lit_free(lit);
    arena_free(&arena);
}

static void refuse_file(Arena *arena, const char *path, const char *text, const char *expected) {
    Error error = {""};
    Probes probes = {0};
    cr_assert(file_write(path, text, strlen(text), &error));
    cr_assert_not(bake_probes_read(path, arena, &probes, &error));
    cr_assert_not_null(strstr(error.text, expected), "says `%s`", error.text);
}

// Proves that a file of points is read with its remarks, and that a bad line is named.
Test(bake_probes, are_read) {
    Arena arena = {0};
    Error error = {""};
    Probes probes = {0};
    const char *path = arena_format(&arena, "%s/points", support_folder(&arena));
    static const char GOOD[] =
        "# points\n\n1 2 3 0 0 1\r\n 1,2,3, 0,0,-5 # below\nquad q .5 0 0 0 0 1 0 0 1 1 0 0 1 0\n"
        "point name 4 5 6 1 0 0 q\n";
    cr_assert(file_write(path, GOOD, sizeof GOOD - 1, &error));
    cr_assert(bake_probes_read(path, &arena, &probes, &error), "%s", error.text);
    cr_assert_eq(probes.count, 3);
    cr_assert_eq(probes.probes[1].normal.z, -1);
    cr_assert_eq(probes.probes[2].place.y, 5);
    refuse_file(&arena, path, "1 2 3 0 0 1\n1 2 3 0 0\n", "points:2: is `1 2 3 0 0` (expected");
    refuse_file(&arena, path, "1 2 3 0 0 1 7\n", "points:1: is");
    refuse_file(&arena, path, "1 2 3 0 0 0\n", "points:1: a probe has no normal");
    refuse_file(&arena, path, "1 2 nan 0 0 1\n", "has the number nan");
    arena_free(&arena);
}

// Proves that a point that its digits put a little behind a slanted face, or before it, has the light of the face. Tolerance: light
// changes less over a micrometre, and all points take the same random numbers.
Test(bake_probes, beside_a_slanted_face) {
    static const double OFF[] = {-1e-6, -1e-8, -2e-9, -1e-10, 1e-8, 1e-6};
    Lit *lit = lit_new();
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    lit_lamp(lit, vec3(2, 1.5, 2.4));
    lit_quad(lit, vec3(1, 0.5, 0), vec3(1.3, 1.5, 0.1), vec3(0.7, 1.7, 1.2), vec3(0.4, 0.7, 1.1), LIT_WALL);
    lit_finish(lit, 0.5, 2);
    RadSolution solution;
    RadOptions options = rad_default_options();
    lit_shoot(lit, &options, &solution);
    GatherScene scene = {&lit->mesh, &lit->forest, NULL, &solution, NULL};
    const Face *face = &lit->mesh.faces[lit->mesh.face_count - 1];
    Vec3 n = face->plane.n, on = vec3(0.85, 1.1, 0.6);
    on = vec3_sub(on, vec3_scale(n, vec3_dot(n, vec3_sub(on, face->origin))));
    Probe exact = {.place = on, .normal = n};
    bake_probes_gather(&scene, 1, &(Probes){&exact, 1, 1});
    cr_assert_gt(exact.irradiance[1], 0);
    for (size_t i = 0; i < sizeof OFF / sizeof *OFF; i++) {
        Probe beside = {.place = vec3_add(on, vec3_scale(n, OFF[i])), .normal = n};
        bake_probes_gather(&scene, 1, &(Probes){&beside, 1, 1});
        cr_expect_float_eq(beside.irradiance[1], exact.irradiance[1], 1e-5 * exact.irradiance[1],
                           "%g m off: %g, not %g", OFF[i], beside.irradiance[1], exact.irradiance[1]);
    }
    lit_free(lit);
}
