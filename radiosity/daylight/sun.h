// sun.h - where the sun stands, from date, hour and place.
#ifndef RADIOSITY_SUN_H
#define RADIOSITY_SUN_H

#include "engine/core/vec.h"

// The sun as a place of the earth sees it.
typedef struct SunPosition {
    double altitude;  // radians above the horizon, refraction included
    double azimuth;   // radians from north, clockwise from above, 0 .. 2 pi
    double distance;  // astronomical units
} SunPosition;

// Dates are Gregorian; `hour` is UTC and may be below 0 or above 24: it counts from the date's midnight. Latitude (north) and longitude
// (east) are in radians. Good to 0.01 degrees from 1900 to 2100.
SunPosition sun_position(int year, int month, int day, double hour, double latitude, double longitude);

// The unit vector to the sun's middle in building space. `north` is the direction of north in the plan, radians clockwise from +y.
Vec3 sun_direction(const SunPosition *sun, double north);

#endif
