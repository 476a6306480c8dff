// day.c - completes the options of daylight by the building's own place and hour, and finds the sun.
#include "engine/scene/day.h"

#include <stdio.h>

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

bool day_over(const DayOptions *o, const Building *b, Daylight *out, Error *error) {
    const Site *site = &b->site;
    *out = (Daylight){0};
    if (day_asks_sky(o) && day_asks_sun(o))
        return error_set(
            error, "%s: an even sky (--sky) and a day with a sun are asked for (one of them is allowed)",
            b->source);
    if (day_asks_sky(o)) *out = daylight_uniform(o->sky);
    if (!day_asks_sun(o)) return true;
    const int *date = o->date[0] ? o->date : site->date[0] ? site->date : USUAL_DATE;
    double hour = !isnan(o->time[0]) ? o->time[0] : site->date[0] ? site->hour : USUAL_HOUR;
    bool placed = !isnan(o->place[0]);
    double latitude = placed ? o->place[0] * DEGREE : site->placed ? site->latitude : USUAL_LATITUDE * DEGREE;
    double longitude = placed ? o->place[1] * DEGREE : site->placed ? site->longitude : 0;
    double north = !isnan(o->north) ? o->north : site->north;
    double ahead = o->time[1];
    if (isnan(ahead))
        ahead = isnan(o->time[0]) && !placed && site->zoned ? site->ahead : longitude / (15 * DEGREE);
    SunPosition sun = sun_position(date[0], date[1], date[2], hour - ahead, latitude, longitude);
    *out = daylight_of(&sun, north, o->weather < 0 ? DAYLIGHT_CLEAR : o->weather);
    if (daylight_shines(out)) return true;
    return error_set(
        error,
        "%s: the sun is %.1f degrees below the horizon on %04d-%02d-%02d at %02d:%02d, latitude %.4g, "
        "longitude %.4g (allowed: day, or twilight down to 6 degrees)",
        b->source, -sun.altitude / DEGREE, date[0], date[1], date[2], (int)hour,
        (int)(60 * (hour - floor(hour)) + 0.5), latitude / DEGREE, longitude / DEGREE);
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
