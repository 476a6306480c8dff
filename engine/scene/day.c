// day.c - completes the options of daylight by the building's own place and hour, and finds the sun.
#include "engine/scene/day.h"

#include <stdio.h>
#include <string.h>

static const double DEGREE = M_PI / 180;
// The usual day: the sun shines into east and south windows of a house in the middle latitudes.
static const int USUAL_DATE[3] = {2026, 6, 21};
static const double USUAL_HOUR = 10, USUAL_LATITUDE = 50;

DayOptions day_default_options(void) {
    return (DayOptions){.time = {NAN, NAN}, .place = {NAN, NAN}, .north = NAN, .weather = -1};
}

bool day_asks_sky(const DayOptions *o) { return rgb_sum(o->sky) > 0; }

bool day_asks_sun(const DayOptions *o) {
    return o->day || o->date[0] != 0 || !isnan(o->time[0]) || !isnan(o->place[0]) || !isnan(o->north) ||
           o->weather >= 0;
}

// When and where a day is, each number from the options, else from the building, else the usual one.
typedef struct When {
    int date[3];
    double hour, ahead;          // of a clock, and hours that it is ahead of UTC
    double latitude, longitude;  // radians
    double north;
} When;

static When when_of(const DayOptions *o, const Building *b) {
    const Site *site = &b->site;
    const int *date = o->date[0] ? o->date : site->date[0] ? site->date : USUAL_DATE;
    bool placed = !isnan(o->place[0]);
    When w = {.hour = !isnan(o->time[0]) ? o->time[0]
                      : site->date[0]    ? site->hour
                                         : USUAL_HOUR,
              .ahead = o->time[1],
              .latitude = placed         ? o->place[0] * DEGREE
                          : site->placed ? site->latitude
                                         : USUAL_LATITUDE * DEGREE,
              .longitude = placed         ? o->place[1] * DEGREE
                           : site->placed ? site->longitude
                                          : 0,
              .north = !isnan(o->north) ? o->north : site->north};
    memcpy(w.date, date, sizeof w.date);
    if (isnan(w.ahead))
        w.ahead = isnan(o->time[0]) && !placed && site->zoned ? site->ahead : w.longitude / (15 * DEGREE);
    return w;
}

static SunPosition sun_at(const When *w, double hour) {
    return sun_position(w->date[0], w->date[1], w->date[2], hour - w->ahead, w->latitude, w->longitude);
}

bool day_over(const DayOptions *o, const Building *b, Daylight *out, Error *error) {
    *out = (Daylight){0};
    if (o->night) return true;
    if (day_asks_sky(o) && day_asks_sun(o))
        return error_set(
            error, "%s: an even sky (--sky) and a day with a sun are asked for (one of them is allowed)",
            b->source);
    if (day_asks_sky(o)) *out = daylight_uniform(o->sky);
    if (!day_asks_sun(o)) return true;
    When w = when_of(o, b);
    SunPosition sun = sun_at(&w, w.hour);
    *out = daylight_of(&sun, w.north, o->weather < 0 ? DAYLIGHT_CLEAR : o->weather);
    if (daylight_shines(out)) return true;
    return error_set(
        error,
        "%s: the sun is %.1f degrees below the horizon on %04d-%02d-%02d at %02d:%02d, latitude %.4g, "
        "longitude %.4g (allowed: day, or twilight down to 6 degrees)",
        b->source, -sun.altitude / DEGREE, w.date[0], w.date[1], w.date[2], (int)w.hour,
        (int)(60 * (w.hour - floor(w.hour)) + 0.5), w.latitude / DEGREE, w.longitude / DEGREE);
}

double day_hour(const DayOptions *options, const Building *building, const Daylight *day) {
    When w = when_of(options, building);
    double nearest = w.hour, most = -1;
    if (!daylight_shines(day) || daylight_is_uniform(day)) return w.hour;
    // The options' own hour, then each minute of the date.
    for (int i = -1; i < 24 * 60; i++) {
        double hour = i < 0 ? w.hour : i / 60.0;
        SunPosition sun = sun_at(&w, hour);
        double cosine = vec3_dot(sun_direction(&sun, w.north), day->sun);
        if (!(cosine > most)) continue;
        most = cosine;
        nearest = hour;
    }
    return nearest;
}

DayOptions day_at_hour(const DayOptions *options, const Building *building, double hour) {
    DayOptions o = *options;
    Daylight day;
    Error error;
    When w = when_of(options, building);
    o.day = true;
    o.night = false;
    memcpy(o.date, w.date, sizeof o.date);
    o.time[0] = hour;
    o.time[1] = w.ahead;
    o.night = !day_over(&o, building, &day, &error);
    return o;
}

void day_usual(const Building *building, Daylight *out) {
    DayOptions usual = day_default_options();
    Error error;
    usual.day = true;
    if (!day_over(&usual, building, out, &error)) *out = (Daylight){0};
}

void day_describe(const Daylight *day, char *out, size_t size) {
    double turn = atan2(day->sun.x, day->sun.y) / DEGREE;
    if (!daylight_shines(day))
        snprintf(out, size, "no daylight");
    else if (daylight_is_uniform(day))
        snprintf(out, size, "a sky of %g,%g,%g W/m^2/sr", day->zenith[0], day->zenith[1], day->zenith[2]);
    else
        snprintf(out, size, "%s sky with the sun %.2f degrees high, %.2f degrees clockwise from +y",
                 daylight_weather_name(day), asin(fmin(fmax(day->sun.z, -1), 1)) / DEGREE,
                 turn < 0 ? turn + 360 : turn);
}
