// test_daylight.c - the radiance of skies against the standard's own formula and quadrature, irradiances against their models.
#include <criterion/criterion.h>

#include "radiosity/daylight/daylight.h"

static const double DEGREE = M_PI / 180;

static Daylight day_at(double degrees, int weather) {
    SunPosition sun = {.altitude = degrees * DEGREE, .azimuth = M_PI, .distance = 1};
    return daylight_of(&sun, 0, weather);
}

static double sum(const double v[3]) { return v[0] + v[1] + v[2]; }

// The light on level ground, by the middles of a grid of altitudes and azimuths: other points and other weights than the product's.
static double integral(const Daylight *day, int channel) {
    enum { RINGS = 400, AROUND = 800 };
    double all = 0, radiance[3];
    for (int i = 0; i < RINGS; i++) {
        double z = M_PI / 2 * (i + 0.5) / RINGS;
        for (int k = 0; k < AROUND; k++) {
            double turn = 2 * M_PI * k / AROUND;
            daylight_radiance(day, vec3(sin(z) * cos(turn), sin(z) * sin(turn), cos(z)), radiance);
            all += radiance[channel] * cos(z) * sin(z) * (M_PI / 2 / RINGS) * (2 * M_PI / AROUND);
        }
    }
    return all;
}

// Proves that an even sky is even, that it gives pi L to level ground, and that nothing comes from below; exactly, since stored light
// must stay the same.
Test(daylight, even_sky) {
    static const double L[3] = {1, 2, 3.3};
    Daylight day = daylight_uniform(L);
    double out[3], below[3];
    cr_expect(daylight_is_uniform(&day) && daylight_shines(&day));
    for (int i = 1; i < 20; i++) {
        daylight_radiance(&day, vec3_normalize(vec3(i, 10 - i, 0.1 * i)), out);
        cr_expect_arr_eq(out, L, sizeof L);
    }
    daylight_horizontal(&day, out);
    daylight_radiance(&day, vec3_normalize(vec3(1, 0, -1)), below);
    for (int c = 0; c < 3; c++) cr_expect(out[c] == M_PI * L[c] && below[c] == 0);
    cr_expect_float_eq(integral(&day, 2), M_PI * L[2], 1e-4);
    day = (Daylight){0};
    cr_expect(!daylight_shines(&day), "a day without numbers is night");
}

// Proves the gradation of the overcast sky: 1 + 4 exp(-0.7 / cos Z), the same all around, so that the zenith is 2.9863 times as bright as
// the horizon. Tolerance: the digits of that number.
Test(daylight, overcast_is_three_times_as_bright_overhead) {
    Daylight day = day_at(40, DAYLIGHT_OVERCAST);
    cr_expect_float_eq(daylight_relative(&day, vec3(0, 0, 1)), 1, 1e-12);
    cr_expect_float_eq(1 / daylight_relative(&day, vec3_normalize(vec3(1, 0, 1e-4))), 2.98634, 1e-5);
    double tilted = daylight_relative(&day, vec3(0, sin(60 * DEGREE), cos(60 * DEGREE)));
    cr_expect_float_eq(tilted, (1 + 4 * exp(-1.4)) / 2.98634, 1e-5);
    cr_expect_float_eq(tilted, daylight_relative(&day, vec3(-sin(60 * DEGREE), 0, cos(60 * DEGREE))), 1e-12);
    cr_expect_eq(sum(day.beam), 0, "clouds hide the sun");
}

// Proves the clear sky: the indicatrix is 1 + 10 (1 - exp(-3 pi / 2)) + 0.45 = 11.3602 at the sun and its last two terms cancel nowhere
// else; the sky is the same on both sides of the sun's meridian, and brighter at the horizon than overhead, away from the sun.
Test(daylight, clear_is_brightest_at_the_sun) {
    Daylight day = day_at(30, DAYLIGHT_CLEAR);
    double overhead = (1 + 10 * (exp(-M_PI) - exp(-1.5 * M_PI)) + 0.45 * 0.25) * (1 - exp(-0.32));
    double at_sun = 11.3602 * (1 - exp(-0.64)) / overhead;
    cr_expect_float_eq(daylight_relative(&day, day.sun), at_sun, 1e-3);
    for (int i = 0; i < 50; i++) {
        Vec3 w = vec3_normalize(vec3(0.1 * i, 1 - 0.05 * i, 0.3)), mirrored = vec3(-w.x, w.y, w.z);
        cr_expect_float_eq(daylight_relative(&day, w), daylight_relative(&day, mirrored), 1e-12);
        cr_expect_lt(daylight_relative(&day, w), at_sun);
    }
    cr_expect_gt(daylight_relative(&day, vec3_normalize(vec3(0, 1, 0.05))), 1.5);
}

// Proves for each weather, with high and low suns, that the radiances add up to the irradiance promised. Tolerance: 2e-4 of it, the
// product's quadrature and the test's.
Test(daylight, radiances_add_up, .timeout = 60) {
    static const double ALTITUDES[] = {0.5, 15, 50, 88};
    for (int w = 0; w < DAYLIGHT_WEATHERS; w++)
        for (int i = 0; i < 4; i++) {
            Daylight day = day_at(ALTITUDES[i], w);
            double mean[3];
            daylight_mean(&day, mean);
            for (int c = 0; c < 3; c += 2)
                cr_expect_float_eq(integral(&day, c) / (M_PI * mean[c]), 1, 2e-4, "%s, sun at %g: %g of %g",
                                   DAYLIGHT_WEATHER_NAMES[w], ALTITUDES[i], integral(&day, c),
                                   M_PI * mean[c]);
        }
}

// Proves the irradiances. At an air mass of 2 (29.9 degrees) Kasten's thickness is 1 / 9.7013, so that the beam has
// 1367 exp(-0.8662 * 3 * 2 / 9.7013) = 800 W/m^2; with the sun overhead the ESRA's sky has 0.07919 * (0.10815 + 1.99657 - 1.10824) * 1367 =
// 107.9 W/m^2. Overcast, a quarter of the light comes through; between, half of the beam. Tolerance: 0.2 %, the air mass rounded.
Test(daylight, irradiances) {
    Daylight clear = day_at(29.9, DAYLIGHT_CLEAR), half = day_at(29.9, DAYLIGHT_INTERMEDIATE);
    cr_expect_float_eq(sum(clear.beam), 800, 1.6, "beam %g", sum(clear.beam));
    cr_expect_float_eq(sum(half.beam), sum(clear.beam) / 2, 1e-9);
    Daylight high = day_at(90, DAYLIGHT_CLEAR), grey = day_at(90, DAYLIGHT_OVERCAST);
    double mean[3], open[3], clouded[3];
    daylight_mean(&high, mean);
    cr_expect_float_eq(M_PI * sum(mean), 107.9, 0.2, "sky %g", M_PI * sum(mean));
    daylight_horizontal(&high, open);
    daylight_horizontal(&grey, clouded);
    cr_expect_float_eq(sum(clouded), sum(open) / 4, 1e-9);
    daylight_below(&high, mean);
    cr_expect_float_eq(sum(mean), DAYLIGHT_GROUND * sum(open) / M_PI, 1e-9);
}

// Proves the colours: a sun that sinks reddens, the clear sky is blue, the overcast sky grey; and dusk: no beam below the horizon, a sky
// that fades over civil twilight, then none.
Test(daylight, colours_and_dusk) {
    Daylight high = day_at(60, DAYLIGHT_CLEAR), low = day_at(3, DAYLIGHT_CLEAR),
             grey = day_at(60, DAYLIGHT_OVERCAST);
    cr_expect(high.beam[0] > high.beam[2] && high.beam[0] < 1.3 * high.beam[2],
              "the high sun is nearly white");
    cr_expect_gt(low.beam[0], 3 * low.beam[2]);
    cr_expect_gt(high.zenith[2], 1.3 * high.zenith[0]);
    cr_expect_float_eq(grey.zenith[2], grey.zenith[0], 1e-12);
    Daylight dusk = day_at(-0.01, DAYLIGHT_CLEAR), late = day_at(-5.9, DAYLIGHT_CLEAR),
             night = day_at(-6.1, DAYLIGHT_CLEAR);
    cr_expect(sum(dusk.beam) == 0 && sum(dusk.zenith) > 0);
    cr_expect_lt(sum(late.zenith), 0.05 * sum(dusk.zenith));
    cr_expect(!daylight_shines(&night));
}

// Proves that a stored day with impossible numbers is told from one that the product makes.
Test(daylight, unsound_days) {
    Daylight night = {0}, good = day_at(20, DAYLIGHT_INTERMEDIATE),
             even = daylight_uniform((const double[]){1, 0, 2});
    cr_expect(daylight_is_sound(&night) && daylight_is_sound(&good) && daylight_is_sound(&even));
    Daylight bad[7] = {good, good, good, good, good, good, even};
    bad[0].beam[1] = -1;
    bad[1].zenith[2] = NAN;
    bad[2].sun.z = 0.9;
    bad[3].cie[1] = 3;
    bad[4].ground = 1.5;
    bad[5].mean = INFINITY;
    bad[6].cie[2] = 1;
    for (int i = 0; i < 7; i++) cr_expect_not(daylight_is_sound(&bad[i]), "day %d", i);
}

// Proves what an eye sees: pi times the radiance of sky and ground, a disc that sends the sun's beam, and no direction near the horizon
// that is darker than sky and ground beside it. The disc's light is its radiosity times the square of the sine of its radius.
Test(daylight, seen_by_direction) {
    Daylight day = day_at(35, DAYLIGHT_CLEAR);
    double seen[3], radiance[3], ground[3], level[3];
    for (int i = 0; i < 40; i++) {
        double turn = 0.3 + 0.15 * i, z = 0.05 + 0.9 * i / 40, across = sqrt(1 - z * z);
        Vec3 w = vec3(across * cos(turn), across * sin(turn), z);
        if (vec3_dot(w, day.sun) > cos(2 * DAYLIGHT_SUN_RADIUS)) continue;
        daylight_seen(&day, w, seen);
        daylight_radiance(&day, w, radiance);
        for (int c = 0; c < 3; c++) cr_expect_float_eq(seen[c] / (M_PI * radiance[c]), 1, 1e-12);
    }
    daylight_seen_ground(&day, ground);
    daylight_seen(&day, vec3_normalize(vec3(1, 1, -1)), seen);
    cr_expect_arr_eq(seen, ground, sizeof seen);
    daylight_seen(&day, day.sun, seen);
    daylight_radiance(&day, day.sun, radiance);
    for (int c = 0; c < 3; c++) {
        double beam = (seen[c] - M_PI * radiance[c]) * DAYLIGHT_SUN_RADIUS * DAYLIGHT_SUN_RADIUS;
        cr_expect_float_eq(beam / day.beam[c], 1, 1e-9);
    }
    daylight_seen(&day, vec3_normalize(vec3(1, -1, 1e-6)), level);
    for (int i = 0; i <= 100; i++) {
        daylight_seen(&day, vec3_normalize(vec3(1, -1, 0.001 - 0.0006 * i)), seen);
        for (int c = 0; c < 3; c++) {
            cr_expect_geq(seen[c], fmin(ground[c], level[c]) * (1 - 1e-3));
            cr_expect_leq(seen[c], fmax(ground[c], level[c]) * (1 + 1e-3));
        }
    }
    const double even[3] = {1, 1, 1};
    day = daylight_uniform(even);
    daylight_seen(&day, vec3(0, 0, -1), seen);
    cr_expect_float_eq(sum(seen) / 3, M_PI * DAYLIGHT_GROUND, 1e-12);
}
