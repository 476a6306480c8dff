// test_blotch.c - blotches by their size: waves of known length and height on a wall are found in their bands, and nowhere else where
// light is even or has an edge.
#include <criterion/criterion.h>

#include <math.h>

#include "engine/bench/light/blotch.h"
#include "engine/core/arena.h"

// A wall of 6 x 6 m, seen from straight ahead in 600 x 600 pixels.
enum { SIDE = 600 };
static const double METRES = 6;

typedef struct Wall {
    Arena arena;
    Vec3 *point, *normal;
    double *shown, *truth;
    BlotchPixels pixels;
} Wall;

// log(shown / truth) and log(truth) at x, y, metres.
static Wall wall_of(double (*ratio)(double x, double y), double (*light)(double x, double y)) {
    Wall w = {.arena = {0}};
    int count = SIDE * SIDE;
    w.point = ARENA_ARRAY(&w.arena, Vec3, count);
    w.normal = ARENA_ARRAY(&w.arena, Vec3, count);
    w.shown = ARENA_ARRAY(&w.arena, double, count);
    w.truth = ARENA_ARRAY(&w.arena, double, count);
    for (int i = 0; i < count; i++) {
        double x = (i % SIDE + 0.5) * METRES / SIDE, y = (i / SIDE + 0.5) * METRES / SIDE;
        w.point[i] = vec3(x, 3, y);
        w.normal[i] = vec3(0, -1, 0);
        w.truth[i] = exp(light(x, y));
        w.shown[i] = w.truth[i] * exp(ratio(x, y));
    }
    w.pixels = (BlotchPixels){count, w.point, w.normal, w.shown, w.truth};
    return w;
}

static double even(double x, double y) {
    (void)x, (void)y;
    return 3;
}

static double wavelength;
static const double HEIGHT = 0.02;
static double wave(double x, double y) {
    (void)y;
    return HEIGHT * sin(2 * M_PI * x / wavelength);
}

// The share of a wave that a Gaussian leaves (its Fourier transform).
static double left_by(double deviation) { return exp(-2 * pow(M_PI * deviation / wavelength, 2)); }

// Proves each band against the closed form of the two Gaussians that bound it: the root of the mean square of a sine, times what
// the narrower leaves and the wider does not. Tolerance: squares of 3 cm average a wave of 20 cm to 0.97 of its height, and the
// borders of the wall, where Gaussians are cut off, are a tenth of it; both together less than a tenth of the wave.
Test(blotch, waves_are_found_in_their_bands) {
    static const double LENGTHS[] = {0.2, 0.3, 0.6, 1};
    for (size_t i = 0; i < sizeof LENGTHS / sizeof *LENGTHS; i++) {
        double rms[BLOTCH_BANDS];
        wavelength = LENGTHS[i];
        Wall w = wall_of(wave, even);
        cr_expect_float_eq(blotch_bands(&w.pixels, rms), 1, 1e-12, "nothing is an edge");
        for (int b = 0; b < BLOTCH_BANDS; b++) {
            double narrow = 0.03 * (1 << b);
            double expected = HEIGHT / sqrt(2) * (left_by(narrow) - left_by(2 * narrow));
            cr_expect_float_eq(rms[b], expected, 0.1 * HEIGHT / sqrt(2), "%g m, band %d: %g, expected %g",
                               wavelength, b, rms[b], expected);
        }
        arena_free(&w.arena);
    }
}

// Proves that light which is too bright all over has no blotches. Tolerance: floats.
static double too_bright(double x, double y) {
    (void)x, (void)y;
    return 0.3;
}
static double slope(double x, double y) { return 0.3 * x + 0.1 * y; }
Test(blotch, even_errors_are_none) {
    double rms[BLOTCH_BANDS];
    Wall w = wall_of(too_bright, slope);
    cr_expect_float_eq(blotch_bands(&w.pixels, rms), 1, 1e-12);
    for (int b = 0; b < BLOTCH_BANDS; b++) cr_expect_lt(rms[b], 1e-5, "band %d: %g", b, rms[b]);
    arena_free(&w.arena);
}

// Proves that an error at the edge of a shadow, where the truth falls to a third within 10 cm, is left out, and nothing else is.
static double shadow(double x, double y) {
    (void)y;
    return -log(3) * fmin(fmax((x - 2.95) / 0.1, 0), 1);
}
static double at_edge(double x, double y) {
    (void)y;
    return fabs(x - 3) < 0.04 ? 0.5 : 0;
}
Test(blotch, edges_of_light_are_left_out) {
    double rms[BLOTCH_BANDS];
    Wall w = wall_of(at_edge, shadow);
    double share = blotch_bands(&w.pixels, rms);
    cr_expect(share > 0.95 && share < 0.99, "%g stay", share);
    for (int b = 0; b < BLOTCH_BANDS; b++) cr_expect_lt(rms[b], 1e-6, "band %d: %g", b, rms[b]);
    arena_free(&w.arena);
}

// Proves that never more than 40 % is left out, however much of the light changes.
static double stripes(double x, double y) {
    (void)y;
    return sin(2 * M_PI * x / 0.3);
}
Test(blotch, most_pixels_stay) {
    double rms[BLOTCH_BANDS];
    Wall w = wall_of(even, stripes);
    double share = blotch_bands(&w.pixels, rms);
    cr_expect(share >= 0.6 && share < 0.8, "%g stay", share);
    arena_free(&w.arena);
}
