// test_false_colour.c - light in numbers: what arrives is found again from what leaves, scales end in round numbers, and the
// colours between them are evenly spaced.
#include <criterion/criterion.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "engine/core/random.h"
#include "engine/lit/false_colour.h"

// Proves each quantity on a surface of known light: B = E + rho H.
Test(false_colour, values_are_those_of_the_light) {
    Material m = {.reflectance = {0.5f, 0.25f, 0.125f}, .emission = {1, 2, 3}};
    double h[3] = {4, 8, 16}, b[3] = {1 + 2, 2 + 2, 3 + 2};
    cr_expect_float_eq(false_colour_value(FALSE_COLOUR_RADIOSITY, b, &m), 12, 1e-9);
    cr_expect_float_eq(false_colour_value(FALSE_COLOUR_IRRADIANCE, b, &m), 28, 1e-6);
    double lux = 683 * (0.2126 * h[0] + 0.7152 * h[1] + 0.0722 * h[2]);
    cr_expect_float_eq(false_colour_value(FALSE_COLOUR_ILLUMINANCE, b, &m), lux, 1e-3);
    m.reflectance.g = 0;
    cr_expect_eq(false_colour_value(FALSE_COLOUR_IRRADIANCE, b, &m), -1, "black tells nothing");
    cr_expect_float_eq(false_colour_value(FALSE_COLOUR_RADIOSITY, b, &m), 12, 1e-9);
}

// 1, 2 or 5 times a power of ten, by its digits.
static bool is_round(double x) {
    char digits[32];
    snprintf(digits, sizeof digits, "%.12e", x);
    return strspn(digits, "125") == 1 && strspn(digits + 2, "0") == 12;
}

// Proves that of any brightest value the scale reaches it, with less than a step to spare, over three powers of ten; that the
// numbers beside it are round, rise, and begin and end with it; and that each stands where its colour is.
Test(false_colour, scales_have_round_numbers) {
    Random random = {8};
    for (int k = 0; k < 2000; k++) {
        double most = k < 20 ? pow(10, k - 10) : exp(random_between(&random, -20, 20));
        double ticks[LIGHT_RANGE_TICKS];
        LightRange range = light_range(most);
        cr_assert(range.high >= most && range.high <= 2.5 * most * (1 + 1e-9), "%g of %g", range.high, most);
        cr_assert_float_eq(range.high / range.low, 1000, 1e-6);
        int count = light_range_ticks(range, ticks);
        cr_assert_eq(count, LIGHT_RANGE_TICKS);
        cr_assert(ticks[0] == range.low && ticks[count - 1] == range.high, "%g .. %g of %g .. %g", ticks[0],
                  ticks[count - 1], range.low, range.high);
        for (int i = 0; i < count; i++) {
            cr_assert(is_round(ticks[i]), "%.17g is not round", ticks[i]);
            cr_assert(i == 0 || ticks[i] > ticks[i - 1]);
            cr_assert_float_eq(range.low * pow(1000, light_range_place(range, ticks[i])), ticks[i],
                               1e-9 * ticks[i]);
        }
    }
    double none = light_range(0).high;
    cr_expect(none > 0, "a dark building has a scale all the same");
}

static double linear(float x) {
    return x <= 0.04045f ? (double)x / 12.92 : pow(((double)x + 0.055) / 1.055, 2.4);
}

// The L, a, b of a colour (Ottosson 2020, the way forth).
static void oklab(Rgb c, double out[3]) {
    double r = linear(c.r), g = linear(c.g), b = linear(c.b);
    double l = cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b),
           m = cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b),
           s = cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
    out[0] = 0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s;
    out[1] = 1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s;
    out[2] = 0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s;
}

// Proves that no colour on the scale is out of the screen's range, where it would be cut off: steps along it are equally long
// to the eye within 1 %, and each is brighter than the one before.
Test(false_colour, colours_are_evenly_spaced) {
    enum { STEPS = 64 };
    double length[STEPS], mean = 0, from[3], to[3];
    oklab(false_colour_at(0), from);
    for (int i = 0; i < STEPS; i++) {
        oklab(false_colour_at((i + 1.0) / STEPS), to);
        length[i] = sqrt(pow(to[0] - from[0], 2) + pow(to[1] - from[1], 2) + pow(to[2] - from[2], 2));
        cr_assert_gt(to[0], from[0], "step %d", i);
        mean += length[i] / STEPS;
        memcpy(from, to, sizeof from);
    }
    for (int i = 0; i < STEPS; i++)
        cr_expect_float_eq(length[i], mean, 0.01 * mean, "step %d is %g, the mean %g", i, length[i], mean);
    Rgb below = false_colour_at(-3), low = false_colour_at(0);
    cr_expect(memcmp(&below, &low, sizeof low) == 0, "what is below the scale has its lowest colour");
}

// Proves that the signed scale is lightest in the middle, darkens evenly and as far to both sides, blue below and red above, and
// ends where it should.
Test(false_colour, signed_scale_has_two_ends) {
    double before = 2;
    for (int i = 0; i <= 10; i++) {
        Rgb low = false_colour_signed(-i / 10.0), high = false_colour_signed(i / 10.0);
        double light = (double)(high.r + high.g + high.b);
        cr_expect_lt(light, before + 1e-6 + (i == 0));
        before = light;
        if (i > 0) cr_expect(low.b > low.r && high.r > high.b, "%d", i);
    }
    Rgb end = false_colour_signed(1), beyond = false_colour_signed(7), zero = false_colour_signed(0);
    cr_expect(end.r == beyond.r && end.g == beyond.g && end.b == beyond.b);
    cr_expect_lt(fabsf(zero.r - zero.b), 0.01f);
}
