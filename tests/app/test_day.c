// test_day.c - options of daylight completed by a building's own place and hour.
#include <criterion/criterion.h>
#include <string.h>

#include "engine/scene/day.h"

static const double DEGREE = M_PI / 180;

// A home in the far south, with north along -x and a clock eight hours ahead, in the afternoon of midwinter.
static const Building HOME = {.source = "home.sh3d",
                              .site = {.placed = true,
                                       .latitude = -30 * M_PI / 180,
                                       .longitude = 115 * M_PI / 180,
                                       .north = 270 * M_PI / 180,
                                       .date = {2026, 6, 21},
                                       .hour = 15.5,
                                       .zoned = true,
                                       .ahead = 8}};
static const Building PLAN = {.source = "a.plan"};

static Daylight day_at(int year, int month, int day, double hour, double latitude, double longitude,
                       double north) {
    SunPosition sun = sun_position(year, month, day, hour, latitude * DEGREE, longitude * DEGREE);
    return daylight_of(&sun, north * DEGREE, DAYLIGHT_CLEAR);
}

static void check(const DayOptions *options, const Building *building, Daylight want) {
    Daylight day;
    Error error;
    cr_assert(day_over(options, building, &day, &error), "%s", error.text);
    cr_expect_lt(vec3_length(vec3_sub(day.sun, want.sun)), 1e-9, "sun at %g %g %g, not %g %g %g", day.sun.x,
                 day.sun.y, day.sun.z, want.sun.x, want.sun.y, want.sun.z);
    cr_expect_arr_eq(day.cie, want.cie, sizeof day.cie);
}

// Proves that each value comes from the option, else from the building, else is the usual one; and that an hour given, or a place, counts
// as mean time, for the building's zone is that of its own hour and place. To rounding.
Test(day, options_before_the_building) {
    DayOptions o = day_default_options();
    Daylight day;
    Error error;
    cr_assert(day_over(&o, &HOME, &day, &error) && !daylight_shines(&day), "night is the default");
    o.day = true;
    check(&o, &HOME, day_at(2026, 6, 21, 7.5, -30, 115, 270));
    check(&o, &PLAN, day_at(2026, 6, 21, 10, 50, 0, 0));
    o.date[0] = 2027, o.date[1] = 3, o.date[2] = 1;
    check(&o, &HOME, day_at(2027, 3, 1, 7.5, -30, 115, 270));
    o.time[0] = 9;
    check(&o, &HOME, day_at(2027, 3, 1, 9 - 115 / 15.0, -30, 115, 270));
    o.time[1] = 2;
    check(&o, &HOME, day_at(2027, 3, 1, 7, -30, 115, 270));
    o.place[0] = 10, o.place[1] = 30, o.north = 0.5;
    check(&o, &HOME, day_at(2027, 3, 1, 7, 10, 30, 0.5 / DEGREE));
    o.weather = DAYLIGHT_OVERCAST;
    cr_assert(day_over(&o, &HOME, &day, &error));
    cr_expect_str_eq(daylight_weather_name(&day), "overcast");
}

// Proves that each option by itself asks for a day, that an even sky excludes them, and that a night is refused with the sun's place.
Test(day, asks_and_refuses) {
    DayOptions o[6];
    Daylight day;
    Error error;
    for (int i = 0; i < 6; i++) o[i] = day_default_options();
    cr_expect(!day_asks(&o[0]));
    o[0].day = true, o[1].date[0] = 2026, o[1].date[1] = 7, o[1].date[2] = 1, o[2].time[0] = 12,
    o[3].place[0] = o[3].place[1] = 0;
    o[4].north = 0, o[5].weather = DAYLIGHT_CLEAR;
    for (int i = 0; i < 6; i++) {
        cr_expect(day_asks_sun(&o[i]) && !day_asks_sky(&o[i]), "option %d", i);
        cr_expect(day_over(&o[i], &PLAN, &day, &error) && daylight_shines(&day), "option %d", i);
        o[i].sky[1] = 3;
        cr_expect_not(day_over(&o[i], &PLAN, &day, &error));
        cr_expect(strstr(error.text, "a.plan: an even sky (--sky) and a day"), "%s", error.text);
    }
    DayOptions sky = day_default_options();
    sky.sky[0] = 3;
    cr_assert(day_over(&sky, &HOME, &day, &error) && daylight_is_uniform(&day) && day.zenith[0] == 3);
    o[2] = day_default_options();
    o[2].time[0] = 1.25;
    cr_assert_not(day_over(&o[2], &PLAN, &day, &error));
    cr_expect(
        strstr(error.text, "degrees below the horizon on 2026-06-21 at 01:15, latitude 50, longitude 0"),
        "%s", error.text);
}

// Proves the words for a day in messages.
Test(day, in_words) {
    char words[128];
    Daylight day = daylight_uniform((const double[]){1, 2, 3});
    day_describe(&day, words, sizeof words);
    cr_expect_str_eq(words, "a sky of 1,2,3 W/m^2/sr");
    SunPosition sun = {30 * DEGREE, 200 * DEGREE, 1};
    day = daylight_of(&sun, 0, DAYLIGHT_INTERMEDIATE);
    day_describe(&day, words, sizeof words);
    cr_expect_str_eq(words,
                     "intermediate sky with the sun 30.00 degrees high, 200.00 degrees clockwise from +y");
}

// Proves that the clock is turned from the building's own hour, beyond midnight too, and into night; and that the hour of stored light is
// known by its sun, to the minute that is looked for.
Test(day, turns_the_clock) {
    DayOptions o = day_default_options();
    Daylight day;
    Error error;
    double noon = day_hour(&o, &HOME, &(Daylight){0});
    cr_expect_float_eq(noon, 15.5, 1e-12);
    DayOptions later = day_at_hour(&o, &HOME, noon + 1);
    check(&later, &HOME, day_at(2026, 6, 21, 8.5, -30, 115, 270));
    later = day_at_hour(&later, &HOME, 36);
    check(&later, &HOME, day_at(2026, 6, 22, 4, -30, 115, 270));
    later = day_at_hour(&later, &HOME, 22);
    cr_expect(later.night && day_over(&later, &HOME, &day, &error) && !daylight_shines(&day));
    later = day_at_hour(&later, &HOME, 9);
    check(&later, &HOME, day_at(2026, 6, 21, 1, -30, 115, 270));
    Daylight stored = day_at(2026, 6, 21, 4.25, -30, 115, 270);
    cr_expect_float_eq(day_hour(&o, &HOME, &stored), 12.25, 1.0 / 60);
    stored = daylight_uniform((const double[]){1, 2, 3});
    cr_expect_float_eq(day_hour(&o, &HOME, &stored), 15.5, 1e-12, "an even sky has no hour");
}
