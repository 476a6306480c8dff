// daylight.h - the light of a day: a sun, a sky whose radiance depends on the direction, and ground that reflects both.
#ifndef RADIOSITY_DAYLIGHT_H
#define RADIOSITY_DAYLIGHT_H

#include "radiosity/daylight/sun.h"

// Weathers, each a type of the CIE Standard General Sky.
enum {
    DAYLIGHT_CLEAR,         // type 12; the sun shines
    DAYLIGHT_INTERMEDIATE,  // type 7; clouds hide the sun half of the time
    DAYLIGHT_OVERCAST,      // type 1; no sun
    DAYLIGHT_WEATHERS
};
// The names that options have for them.
extern const char *const DAYLIGHT_WEATHER_NAMES[DAYLIGHT_WEATHERS];

// The share of the light on level ground that the ground sends back: grass and soil.
#define DAYLIGHT_GROUND 0.2

// Doubles alone, so that files store a day as it is. All zeros: night.
typedef struct Daylight {
    Vec3 sun;          // unit vector to the sun's middle, building space; +z where there is none
    double beam[3];    // irradiance by the sun on a plane across its beam, W/m^2 a channel; 0: no sun
    double zenith[3];  // radiance of the sky overhead, W/m^2/sr a channel
    double cie
        [5];  // a .. e of the standard: gradation a, b from zenith to horizon; indicatrix c, d, e about the sun
    double mean;    // mean radiance of the sky, weighted by the cosine to the zenith, over that overhead
    double ground;  // reflectance of the ground, 0 .. 1
} Daylight;

// A sky of the same radiance everywhere (type 5), W/m^2/sr a channel; no sun, and nothing from below.
Daylight daylight_uniform(const double radiance[3]);
// The day under a sun that stands there. `north` as for sun_direction, `weather` one of DAYLIGHT_....
Daylight daylight_of(const SunPosition *sun, double north, int weather);

// The name of a day's sky: of a weather, or "uniform".
const char *daylight_weather_name(const Daylight *day);

// Does any light come from sun or sky?
bool daylight_shines(const Daylight *day);
// Are all numbers finite, and do no radiances lie below 0? Files may be forged.
bool daylight_is_sound(const Daylight *day);
// Is the sky the same everywhere, without a sun or light from below?
bool daylight_is_uniform(const Daylight *day);

// The product of gradation and indicatrix overhead.
double daylight_overhead(const Daylight *day);
// The radiance of the sky over that overhead. `direction` is a unit vector that points up.
double daylight_relative(const Daylight *day, Vec3 direction);
// The radiance that comes from a unit direction, W/m^2/sr: of the sky above the horizon, of the ground from below. The sun's beam is not
// part of it.
void daylight_radiance(const Daylight *day, Vec3 direction, double out[3]);
// The mean radiance of the sky, weighted by the cosine to the zenith, W/m^2/sr: an even sky of this radiance gives level ground as much.
void daylight_mean(const Daylight *day, double out[3]);
// The irradiance of sky and sun on level ground, W/m^2.
void daylight_horizontal(const Daylight *day, double out[3]);
// The radiance that comes from below the horizon, W/m^2/sr.
void daylight_below(const Daylight *day, double out[3]);

// The radius of the sun's disc, radians, and the sine of the angle below the horizon over which the ground fades into the sky.
#define DAYLIGHT_SUN_RADIUS 0.00465
#define DAYLIGHT_HAZE 0.02
// The light that an eye sees along a unit direction: the radiosity of a diffuse surface that looks as bright, W/m^2. Sky, the sun's disc,
// and ground in the colour of grass, which under an even sky reflects DAYLIGHT_GROUND of its light.
void daylight_seen(const Daylight *day, Vec3 direction, double out[3]);
// That of the ground alone.
void daylight_seen_ground(const Daylight *day, double out[3]);

#endif
