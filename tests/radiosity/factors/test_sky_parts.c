// test_sky_parts.c - the sky in parts: its light under any sun, against directions one by one.
#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/core/random.h"
#include "radiosity/factors/sky_parts.h"

static Daylight day_at(double altitude, double azimuth, int weather) {
    SunPosition sun = {.altitude = altitude * M_PI / 180, .azimuth = azimuth * M_PI / 180, .distance = 1};
    return daylight_of(&sun, 0, weather);
}

// Directions evenly spread over a window in the sky: `across` radians about a middle.
static Vec3 direction_in(Random *random, Vec3 middle, double across) {
    for (;;) {
        Vec3 off = {random_unit(random) - 0.5, random_unit(random) - 0.5, random_unit(random) - 0.5};
        Vec3 w = vec3_normalize(vec3_add(middle, vec3_scale(off, across)));
        if (w.z > 0) return w;
    }
}

static Vec3 any_direction(Random *random) {
    double z = random_unit(random), angle = 2 * M_PI * random_unit(random), across = sqrt(1 - z * z);
    return vec3(across * cos(angle), across * sin(angle), z);
}

// Proves that the light of parts is that of their directions: exact under the sun for which they were fitted, and under any other within
// the bound that follows from their size. Radiance is linear across a part but for its second derivative, 90 exp(-3 angle) by the
// indicatrix of a clear sky, which is 11 about the sun. A square of 6 degrees, the largest one of the map, has a variance of .0009 along
// each axis. Half of it times 90 is .041 of 11, or .4 %. Squares twice as wide have four times that, but whole skies have hundreds of
// them. In the one that holds the sun the indicatrix has an edge, and is off by a tenth. So one in a hundred is allowed.
Test(sky_parts, light_under_any_sun) {
    enum { VIEWS = 200, DIRECTIONS = 2000 };
    Arena arena = {0};
    Random random = {3};
    SkyCollector *collector = sky_collector_new(&arena);
    SkyPart *part = ARENA_ARRAY(&arena, SkyPart, SKY_PARTS_MOST);
    Vec3 *way = ARENA_ARRAY(&arena, Vec3, DIRECTIONS);
    double worst[2] = {0, 0};
    int most[2] = {0, 0};
    for (int v = 0; v < VIEWS; v++) {
        bool wide = v % 2;
        Vec3 middle = any_direction(&random);
        double across = 0.1 + 0.6 * random_unit(&random), share = wide ? 0.5 : 0.05;
        for (int i = 0; i < DIRECTIONS; i++) {
            way[i] = wide ? any_direction(&random) : direction_in(&random, middle, across);
            sky_collector_add(collector, share / DIRECTIONS, way[i]);
        }
        int count = sky_collector_take(collector, part);
        most[wide] = count > most[wide] ? count : most[wide];
        for (int k = 0; k < 4; k++) {
            Daylight day =
                day_at(5 + 80 * random_unit(&random), 360 * random_unit(&random), k % DAYLIGHT_WEATHERS);
            double sum = 0;
            for (int i = 0; i < DIRECTIONS; i++) sum += share / DIRECTIONS * daylight_relative(&day, way[i]);
            double off = fabs(sky_parts_light(part, count, &day) / sum - 1);
            worst[wide] = fmax(worst[wide], off);
            sky_parts_fit(part, count, &day, sum);
            cr_expect_float_eq(sky_parts_light(part, count, &day), sum, 1e-6 * sum);
        }
    }
    printf("light of parts is %.3f %% off at most through windows, %.3f %% of whole skies; %d and %d parts\n",
           100 * worst[0], 100 * worst[1], most[0], most[1]);
    cr_expect(worst[0] < 0.01 && worst[1] < 0.01, "%g %g", worst[0], worst[1]);
    cr_expect(most[0] < SKY_PARTS_MOST && most[1] <= SKY_PARTS_MOST / 4);
    arena_free(&arena);
}

// Proves that a collector begins anew after each view.
Test(sky_parts, views_do_not_mix) {
    Arena arena = {0};
    SkyCollector *collector = sky_collector_new(&arena);
    SkyPart *part = ARENA_ARRAY(&arena, SkyPart, SKY_PARTS_MOST);
    for (int i = 0; i < 3; i++) {
        sky_collector_add(collector, 0.25, vec3(0, 0, 1));
        sky_collector_add(collector, 0.5, vec3(0.6, 0, 0.8));
        int count = sky_collector_take(collector, part);
        cr_assert_eq(count, 2);
        cr_expect_eq(part[0].share, 0.25F);
        cr_expect_eq(part[1].share, 0.5F);
        cr_expect_lt(abs(part[1].x - (int)(0.6 * SKY_PART_ONE)), 2);
    }
    cr_expect_eq(sky_collector_take(collector, part), 0);
    arena_free(&arena);
}
