// test_sun.c - the sun's position against published positions, and against the seasons' closed forms.
#include <criterion/criterion.h>

#include "radiosity/daylight/sun.h"

static const double DEGREE = M_PI / 180;

static SunPosition at(int year, int month, int day, double hour, double latitude, double longitude) {
    SunPosition sun = sun_position(year, month, day, hour, latitude * DEGREE, longitude * DEGREE);
    sun.altitude /= DEGREE;
    sun.azimuth /= DEGREE;
    return sun;
}

// The highest or lowest position (sign 1 or -1) of a day, minute by minute.
static SunPosition extreme(int year, int month, int day, double latitude, double longitude, int sign) {
    SunPosition best = at(year, month, day, 0, latitude, longitude);
    for (int minute = 1; minute < 24 * 60; minute++) {
        SunPosition sun = at(year, month, day, minute / 60.0, latitude, longitude);
        if (sign * sun.altitude > sign * best.altitude) best = sun;
    }
    return best;
}

// Proves the whole chain against the example of I. Reda & A. Andreas, Solar Position Algorithm for Solar Radiation Applications, 2004: a
// zenith angle of 50.11162 and an azimuth of 194.34024 degrees. Tolerance: the 0.01 degrees that the series promise; the example's air
// is thinner, which lifts the sun by 0.004 degrees less.
Test(sun, reda_and_andreas) {
    SunPosition sun = at(2003, 10, 17, 19.5 + 30.0 / 3600, 39.742476, -105.1786);
    cr_expect_float_eq(90 - sun.altitude, 50.11162, 0.01, "zenith angle %.5f", 90 - sun.altitude);
    cr_expect_float_eq(sun.azimuth, 194.34024, 0.01, "azimuth %.5f", sun.azimuth);
}

// Proves declination and distance against example 25.a of Meeus, Astronomical Algorithms: -7.78507 degrees and 0.99766 on 1992 October
// 13.0. At the pole the altitude is the declination, less the parallax of 0.0024 degrees. Tolerance: the last digits, and the minute
// between terrestrial and universal time, in which the sun sinks by 0.0003 degrees.
Test(sun, meeus) {
    SunPosition sun = at(1992, 10, 13, 0, 90, 0);
    cr_expect_float_eq(sun.altitude, -7.78507 - 0.0024, 0.001, "altitude %.5f", sun.altitude);
    cr_expect_float_eq(sun.distance, 0.99766, 1e-5, "distance %.6f", sun.distance);
}

// Proves the seasons of 2000 by their moments in almanacs (equinox March 20 07:35 UTC; solstices June 21 01:48 and December 21 13:37):
// at a place that has noon then, the altitude is 90 degrees less the latitude, plus the ecliptic's obliquity of 23.4393 or less it.
// Tolerance: 0.01 degrees beside refraction, which lifts the sun by 0.008 at 63 degrees, by 0.02 at 40, by 0.055 at 17.
Test(sun, noon_at_equinox_and_solstices) {
    static const struct {
        int month, day;
        double hour, altitude, lift;
    } CASES[] = {{3, 20, 7 + 35 / 60.0, 40, 0.020},
                 {6, 21, 1 + 48 / 60.0, 40 + 23.4393, 0.008},
                 {12, 21, 13 + 37 / 60.0, 40 - 23.4393, 0.055}};
    for (int i = 0; i < 3; i++) {
        SunPosition highest = extreme(2000, CASES[i].month, CASES[i].day, 50, (12 - CASES[i].hour) * 15, 1);
        cr_expect_float_eq(highest.altitude, CASES[i].altitude + CASES[i].lift, 0.01, "case %d: %.4f", i,
                           highest.altitude);
        cr_expect_float_eq(highest.azimuth, 180, 0.5, "case %d: noon lies at %.3f", i, highest.azimuth);
    }
}

// Proves that at 70 degrees north the sun does not set at midsummer, when its lowest altitude is the obliquity less 20 degrees (lifted
// by 0.2 degrees, for it is low), and does not rise at midwinter. Tolerance: 0.05 degrees, a fifth of that lift.
Test(sun, polar_day_and_night) {
    SunPosition low = extreme(2000, 6, 21, 70, 20, -1), high = extreme(2000, 12, 21, 70, 20, 1);
    cr_expect_float_eq(low.altitude, 23.4393 - 20 + 0.22, 0.05, "midnight sun at %.3f", low.altitude);
    cr_expect_lt(high.altitude, -2.5, "midwinter's noon at %.3f", high.altitude);
}

// Proves that south of the tropics the sun stands in the north at noon, in the east before: that latitude and hour angle have their signs.
Test(sun, southern_hemisphere) {
    SunPosition noon = extreme(2026, 6, 21, -33.87, 151.21, 1);
    double from_north = fmin(noon.azimuth, 360 - noon.azimuth);
    cr_expect_lt(from_north, 0.5, "noon lies at %.3f", noon.azimuth);
    cr_expect_float_eq(noon.altitude, 90 - 33.87 - 23.44, 0.05, "altitude %.3f", noon.altitude);
    SunPosition morning = at(2026, 6, 21, 8 - 151.21 / 15, -33.87, 151.21);
    cr_expect(morning.azimuth > 30 && morning.azimuth < 70, "eight o'clock lies at %.3f", morning.azimuth);
}

// Proves that hours beyond a day are those of the neighbouring days, which mean times of far longitudes need; to rounding.
Test(sun, hours_run_on) {
    SunPosition a = at(2026, 2, 28, 25, 50, 0), b = at(2026, 3, 1, 1, 50, 0), c = at(2026, 3, 2, -23, 50, 0);
    cr_expect_float_eq(a.azimuth, b.azimuth, 1e-6);
    cr_expect_float_eq(c.altitude, b.altitude, 1e-6);
}

// Proves how the plan is turned: with north along +y an eastern sun is along +x; with north turned clockwise to +x, east is -y.
Test(sun, direction_in_the_plan) {
    SunPosition east = {.altitude = 30 * DEGREE, .azimuth = 90 * DEGREE};
    Vec3 a = sun_direction(&east, 0), b = sun_direction(&east, 90 * DEGREE);
    cr_expect_lt(vec3_length(vec3_sub(a, vec3(cos(30 * DEGREE), 0, 0.5))), 1e-12);
    cr_expect_lt(vec3_length(vec3_sub(b, vec3(0, -cos(30 * DEGREE), 0.5))), 1e-12);
}
