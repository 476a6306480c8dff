// day.h - daylight as a user asks for it, and the day that it is over a building.
#ifndef SCENE_DAY_H
#define SCENE_DAY_H

#include "maps/building/building.h"
#include "radiosity/daylight/daylight.h"

// An option that was not given takes the building's own value, else a usual one: 21 June, 10:00, 50 degrees north, north along +y, clear.
typedef struct DayOptions {
    // An even sky by itself, radiance in W/m^2/sr a channel; 0: none.
    double sky[3];
    // Daylight is asked for, with nothing said about it; no daylight is asked for.
    bool day, night;
    // Where nothing is asked for and no light is stored, it is day, if it is day at the building's own hour.
    bool usual;
    // Year, month, day; year 0: not given.
    int date[3];
    // Hours of a clock, and the hours that it is ahead of UTC: NAN, it shows the mean time of the place's longitude. Hours NAN: not given.
    double time[2];
    // Degrees north and degrees east; NAN: not given.
    double place[2];
    // Direction of north in the plan, radians clockwise from +y; NAN: not given.
    double north;
    // One of DAYLIGHT_...; -1: not given.
    int weather;
} DayOptions;
// Night.
DayOptions day_default_options(void);

// Is an even sky asked for? A day with a sun?
bool day_asks_sky(const DayOptions *options);
bool day_asks_sun(const DayOptions *options);
// Is any daylight asked for?
static inline bool day_asks(const DayOptions *options) {
    return day_asks_sky(options) || day_asks_sun(options);
}

// The day over a building; all zeros where none is asked for. Fails where an even sky is asked for as well as a sun, and where it is night
// at that hour.
bool day_over(const DayOptions *options, const Building *building, Daylight *out, Error *error);

// The usual day over a building; all zeros where it is night at the building's own hour.
void day_usual(const Building *building, Daylight *out);

// The hour under which a day is shown, of the clock of the options' date: theirs, or where the day is another one, as that of stored light
// may be, the hour at which the sun stands nearest to the day's.
double day_hour(const DayOptions *options, const Building *building, const Daylight *day);
// The options at another hour of that clock; hours below 0 and above 24 are those of the days beside it. Where the sun is too low for
// daylight it is night.
DayOptions day_at_hour(const DayOptions *options, const Building *building, double hour);

// A day in words, for messages: `size` bytes at most.
void day_describe(const Daylight *day, char *out, size_t size);

#endif
