// test_path_tracer.c - the path tracer, which is the truth for solutions: against closed forms and the reference scenes; the
// same bytes on any number of threads; and that no light leaks.
#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/app/bake_probes.h"
#include "maps/maps.h"
#include "radiosity/truth/path_tracer.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

// How many standard errors a result may be off: by chance one in 16,000 is, and seeds are fixed.
#define ERRORS 4

static PathQuery query_at(Vec3 point, Vec3 normal, double error) {
    return (PathQuery){point, normal, error, 0, 4000000, 11};
}

static PathResult trace(const Lit *lit, const Daylight *day, PathQuery query) {
    Arena arena = {0};
    PathTracer *tracer = path_tracer_new(&lit->mesh, day, &arena);
    PathResult result;
    path_tracer_irradiance(tracer, &query, 1, 1, &result);
    path_tracer_end(tracer);
    arena_free(&arena);
    return result;
}

static void check(const PathResult *result, int channel, double expected, double error) {
    double off = result->irradiance[channel] - expected, e = result->standard_error[channel];
    cr_assert_leq(fabs(off), ERRORS * e, "%.7g +- %.2g, not %.7g", result->irradiance[channel], e, expected);
    cr_assert_leq(e, 1.5 * error * expected, "the standard error is %.2g of it", e / expected);
}

// A point under the centre of a unit square, one metre below (as in test_bake_probes.c).
static const double UNDER_SQUARE = .23945647046;

static Lit *black_room(void) {
    Lit *lit = lit_new();
    lit->building->materials[LIT_WALL].reflectance = (Rgb){0, 0, 0};
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    lit_lamp(lit, vec3(2, 1.5, 2));
    return lit;
}

// Proves that direct light is right: under a lamp in a black room; and a centimetre below it, where almost all that is seen is
// the lamp. Its back sends nothing up.
Test(path_tracer, lamp_in_a_black_room) {
    Lit *lit = black_room();
    lit_finish(lit, 1, 1);
    PathResult r = trace(lit, NULL, query_at(vec3(2, 1.5, 1), vec3(0, 0, 1), 1e-3));
    check(&r, 0, 12 * UNDER_SQUARE, 1e-3);
    check(&r, 2, 6 * UNDER_SQUARE, 1e-3);
    // The closed form of the corner of a square of side 1/2, four times.
    double a = 50 / sqrt(1 + 50 * 50);
    r = trace(lit, NULL, query_at(vec3(2, 1.5, 1.99), vec3(0, 0, 1), 1e-3));
    check(&r, 1, 10 * 4 / M_PI * a * atan(a), 1e-3);
    r = trace(lit, NULL, query_at(vec3(2, 1.5, 2.5), vec3(0, 0, -1), 1e-3));
    cr_assert_eq(r.irradiance[0], 0);
    lit_free(lit);
}

// A room in which every surface emits E and reflects rho: B = E / (1 - rho) everywhere, and H as much.
static void check_furnace(float rho, double error) {
    Lit *lit = lit_new();
    lit->building->materials[LIT_WALL] =
        (Material){.name = "wall", .reflectance = {rho, rho, 0}, .emission = {1, 2, 3}, .alpha = 1};
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    lit_box(lit, vec3(1, 1, 0), vec3(2, 1.7, 1), false, LIT_WALL, 1 << 4);
    lit_finish(lit, 1, 1);
    static const Vec3 POINTS[3] = {{0.3, 0.4, 0}, {3.99, 1.5, 0.002}, {1.5, 1.2, 1}};
    static const Vec3 NORMALS[3] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    for (int i = 0; i < 3; i++) {
        PathResult r = trace(lit, NULL, query_at(POINTS[i], NORMALS[i], error));
        check(&r, 0, 1 / (1 - (double)rho), error);
        check(&r, 1, 2 / (1 - (double)rho), error);
        // Nothing is reflected: what arrives is what is emitted, wherever one looks.
        cr_assert_float_eq(r.irradiance[2], 3, 4 * r.standard_error[2] + 1e-9);
    }
    lit_free(lit);
}

// Proves that what is reflected is counted once, and lost nowhere, in corners and around furniture; with walls of 0.95 as well.
Test(path_tracer, furnace) {
    check_furnace(0.5f, 1e-3);
    check_furnace(0.95f, 3e-3);
}

static void check_reference(const char *name, const char *own, int channel) {
    Arena arena = {0};
    Error error = {""};
    char *path = arena_string(&arena, support_either(arena_format(&arena, "radiosity/%s.quads", name),
                                                     arena_format(&arena, "tests/seeds/%s.quads", own)));
    Bytes text = support_read(&arena, support_either(arena_format(&arena, "radiosity/%s.ref", name),
                                                     arena_format(&arena, "tests/seeds/%s.ref", own)));
    Lit *lit = lit_new();
    *lit->building = (Building){0};
    cr_assert(maps_read(path, &lit->arena, lit->building, &error), "%s", error.text);
    lit_finish(lit, 0.5, 2);
    Probes probes = {0};
    cr_assert(bake_probes_read(path, &arena, &probes, &error), "%s", error.text);
    PathTracer *tracer = path_tracer_new(&lit->mesh, NULL, &arena);
    int at = 0, apart = support_count(3, 1);  // of the points that are looked at
    for (char *line = strtok((char *)text.data, "\n"); line; line = strtok(NULL, "\n")) {
        double h, e;
        char point[64];
        if (sscanf(line, "%63[^# ] %*f %*f %lf %lf", point, &h, &e) != 3) continue;
        if (at++ % apart != 0) continue;
        PathQuery query = query_at(probes.probes[at - 1].place, probes.probes[at - 1].normal, 2e-3);
        PathResult r;
        path_tracer_irradiance(tracer, &query, 1, 1, &r);
        double off = r.irradiance[channel] - h, both = hypot(r.standard_error[channel], e);
        printf("%s %s: %.5f +- %.5f, reference %.5f +- %.5f, %lld paths\n", name, point,
               r.irradiance[channel], r.standard_error[channel], h, e, r.paths);
        cr_expect_leq(fabs(off), ERRORS * both, "%s: off by %.1f standard errors", point, off / both);
    }
    cr_assert_eq(at, probes.count);
    path_tracer_end(tracer);
    lit_free(lit);
    arena_free(&arena);
}

// Prove that light is right at the points where two other random-walk programs agree.
Test(path_tracer, box_with_two_boxes) { check_reference("boxA", "boxes", 1); }
Test(path_tracer, two_rooms) { check_reference("twoRoom", "two-rooms", 1); }

// Proves that the result does not depend on the number of threads.
Test(path_tracer, same_on_any_number_of_threads) {
    Lit *lit = lit_rooms(5);
    Arena arena = {0};
    PathTracer *tracer = path_tracer_new(&lit->mesh, NULL, &arena);
    enum { POINTS = 24 };
    PathQuery queries[POINTS];
    PathResult one[POINTS], three[POINTS];
    for (int i = 0; i < POINTS; i++) {
        const Patch *patch = &lit->mesh.patches[i * lit->mesh.patch_count / POINTS];
        queries[i] = query_at(patch->centre, lit->mesh.faces[patch->face].plane.n, 0.02);
        queries[i].seed = (uint64_t)i;
        queries[i].most_paths = 100000;
    }
    path_tracer_irradiance(tracer, queries, POINTS, 1, one);
    path_tracer_irradiance(tracer, queries, POINTS, 3, three);
    cr_assert_arr_eq(one, three, sizeof one);
    path_tracer_end(tracer);
    lit_free(lit);
    arena_free(&arena);
}

// Proves that nothing leaks: into a dark room of black walls, whose walls have no thickness and whose floor and ceiling are cut
// as the neighbours' walls are not, from bright rooms all around and from the sky.
Test(path_tracer, no_leaks) {
    Lit *lit = lit_new();
    lit->building->materials[LIT_RED].emission = (Rgb){100, 100, 100};
    lit_box(lit, vec3(0, 0, 0), vec3(3, 3, 2.5), true, LIT_WALL, 0);
    lit_box(lit, vec3(3, 0, 0), vec3(6, 4, 2.5), true, LIT_RED, 0);
    lit_box(lit, vec3(-3, -1, 0), vec3(0, 3, 2.5), true, LIT_RED, 0);
    lit_box(lit, vec3(0, 3, -0.5), vec3(3, 6, 2.5), true, LIT_RED, 0);
    lit_box(lit, vec3(0, -3, 0), vec3(2.1, 0, 3), true, LIT_RED, 0);
    lit_finish(lit, 1, 1);
    const Daylight day = daylight_uniform((const double[]){100, 100, 100});
    static const Vec3 POINTS[4] = {{1.5, 1.5, 0}, {2.9999, 2.9999, 0}, {0.001, 0.001, 0}, {2.1, 0.0001, 0}};
    for (int i = 0; i < 4; i++) {
        PathQuery query = query_at(POINTS[i], vec3(0, 0, 1), 1e-3);
        query.most_paths = 1000000;
        PathResult r = trace(lit, &day, query);
        cr_assert_eq(r.irradiance[0], 0, "%g leaks to point %d", r.irradiance[0], i);
    }
    lit_free(lit);
}

// Proves that a lamp is found among ten thousand, by closed forms: a ceiling of 100 x 100 small lamps shines as one large
// lamp does, and that takes no more paths than ten times as many as for one.
Test(path_tracer, ten_thousand_lamps) {
    Lit *lit = lit_new();
    lit->building->materials[LIT_WALL].reflectance = (Rgb){0, 0, 0};
    lit_box(lit, vec3(0, 0, 0), vec3(4, 4, 2), true, LIT_WALL, 1 << 5);
    for (int i = 0; i < 100; i++) {
        for (int j = 0; j < 100; j++) {
            double x = 4 * i / 100.0, y = 4 * j / 100.0, e = 4 / 100.0;
            lit_quad(lit, vec3(x, y, 2), vec3(x, y + e, 2), vec3(x + e, y + e, 2), vec3(x + e, y, 2),
                     LIT_LAMP);
        }
    }
    lit_finish(lit, 1, 1);
    double a = 1 / sqrt(2), h = 10 * 4 / M_PI * a * atan(a);
    PathResult r = trace(lit, NULL, query_at(vec3(2, 2, 0), vec3(0, 0, 1), 2e-3));
    check(&r, 1, h, 2e-3);
    cr_assert_lt(r.paths, 500000, "%lld paths", r.paths);
    lit_free(lit);
}

// Proves that the sky shines where nothing is met, from above only: pi L on the ground, half of it on a wall, nothing from
// below.
Test(path_tracer, sky) {
    Lit *lit = lit_new();
    lit_quad(lit, vec3(0, 0, 0), vec3(1, 0, 0), vec3(1, 1, 0), vec3(0, 1, 0), LIT_WALL);
    lit_finish(lit, 1, 1);
    const Daylight day = daylight_uniform((const double[]){1, 2, 3});
    PathResult r = trace(lit, &day, query_at(vec3(0.5, 0.5, 0), vec3(0, 0, 1), 1e-3));
    cr_assert_float_eq(r.irradiance[1], 2 * M_PI, 1e-9);
    r = trace(lit, &day, query_at(vec3(0.5, 0.5, 5), vec3(1, 0, 0), 1e-3));
    check(&r, 2, 3 * M_PI / 2, 1e-3);
    r = trace(lit, &day, query_at(vec3(0.5, 0.5, 0), vec3(0, 0, -1), 1e-3));
    cr_assert_eq(r.irradiance[0], 0);
    lit_free(lit);
}

static void check_learned(const Lit *lit, const Daylight *day, double error, double share) {
    Arena arena = {0};
    enum { POINTS = 4 };
    static const Vec3 PLACES[POINTS] = {{0.4, 0.4, 0}, {3.5, 2.4, 0}, {1.1, 2.2, 0}, {2, 0, 1.2}};
    PathQuery queries[POINTS];
    PathResult plain[POINTS], learned[POINTS], again[POINTS];
    long long paths[2] = {0, 0};
    for (int i = 0; i < POINTS; i++)
        queries[i] = query_at(PLACES[i], i < 3 ? vec3(0, 0, 1) : vec3(0, 1, 0), error);
    PathTracer *tracer = path_tracer_new(&lit->mesh, day, &arena);
    path_tracer_irradiance(tracer, queries, POINTS, 0, plain);
    path_tracer_learn(tracer, queries, POINTS, 60000, 1);
    path_tracer_irradiance(tracer, queries, POINTS, 1, learned);
    path_tracer_learn(tracer, queries, POINTS, 60000, 3);
    path_tracer_irradiance(tracer, queries, POINTS, 3, again);
    cr_assert_arr_eq(learned, again, sizeof learned);
    for (int i = 0; i < POINTS; i++) {
        const PathResult *p = &plain[i], *l = &learned[i];
        for (int c = 0; c < 3; c++) {
            double both = hypot(p->standard_error[c], l->standard_error[c]);
            cr_expect_leq(fabs(l->irradiance[c] - p->irradiance[c]), 3 * both,
                          "point %d, channel %d: %.6g, not %.6g +- %.2g", i, c, l->irradiance[c],
                          p->irradiance[c], both);
        }
        paths[0] += p->paths;
        paths[1] += l->paths;
    }
    printf("%lld walks, learned %lld\n", paths[0], paths[1]);
    cr_expect_lt((double)paths[1], share * (double)paths[0], "%lld walks, learned %lld", paths[0], paths[1]);
    path_tracer_end(tracer);
    arena_free(&arena);
}

// Proves that a tracer that has learned finds the same light, within three standard errors, with fewer walks and on any number of
// threads: under a lamp in a shade, below a room whose lamps are closer and not to be seen. And by day in a room with a small window,
// without a sun and with one that shines in.
Test(path_tracer, learned_light_is_the_same) {
    Lit *lit = lit_new();
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 0);
    lit_box(lit, vec3(0, 0, 2.5), vec3(4, 3, 5), true, LIT_WALL, 0);
    for (int i = 0; i < 6; i++) lit_lamp(lit, vec3(0.7 + 1.2 * (i % 3), 0.8 + 1.2 * (i / 3), 2.6));
    lit_lamp(lit, vec3(2, 1.5, 2));
    lit_box(lit, vec3(1.4, 0.9, 1.6), vec3(2.6, 2.1, 2.1), true, LIT_WALL, 1 << 4);
    lit_box(lit, vec3(1.3, 0.8, 1.6), vec3(2.7, 2.2, 2.2), false, LIT_WALL, 1 << 4);
    lit_finish(lit, 1, 1);
    check_learned(lit, NULL, 5e-3, 0.6);
    lit_free(lit);

    lit = lit_new();
    lit_box(lit, vec3(0, 0, 0), vec3(4, 3, 2.5), true, LIT_WALL, 1 << 1);
    // The wall at x = 4 around a window: below, above, and at its sides.
    static const double PARTS[4][4] = {{0, 3, 0, 1}, {0, 3, 1.6, 2.5}, {0, 1, 1, 1.6}, {1.6, 3, 1, 1.6}};
    for (int i = 0; i < 4; i++) {
        const double *p = PARTS[i];
        lit_quad(lit, vec3(4, p[0], p[2]), vec3(4, p[0], p[3]), vec3(4, p[1], p[3]), vec3(4, p[1], p[2]),
                 LIT_WALL);
    }
    lit_finish(lit, 1, 1);
    const Daylight day = daylight_uniform((const double[]){1, 2, 3});
    check_learned(lit, &day, 1e-2, 0.6);
    Daylight sunny = day;
    sunny.sun = vec3_normalize(vec3(1, 0.1, 0.5));
    for (int c = 0; c < 3; c++) sunny.beam[c] = 100;
    check_learned(lit, &sunny, 1e-2, 0.6);
    lit_free(lit);
}
