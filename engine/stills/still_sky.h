// still_sky.h - the light where a ray meets nothing: by day sky, sun and ground as bright as they light, or the building's picture of
// the sky; by night the sky of a walk.
#ifndef STILLS_STILL_SKY_H
#define STILLS_STILL_SKY_H

#include "maps/building/texture.h"
#include "radiosity/daylight/daylight.h"

typedef struct StillSky {
    Daylight day;
    double exposure;  // divides the night sky, which is given as it is on the screen
    double outdoors;  // the day is shown by this factor
    const Building *building;
    double scale;   // of the picture's colours, W/m^2; 0: there is no picture, or it is night
    double texels;  // of the picture between neighbouring rays
} StillSky;

// `spread`: the angle between neighbouring rays, radians. The picture is scaled so that level ground is lit as much as by the day's sky.
StillSky still_sky(const Building *building, const Daylight *day, double exposure, double spread);
// `context` is a StillSky. The radiosity of a diffuse surface that looks as bright, W/m^2 a channel.
void still_sky_at(const void *context, Vec3 direction, double out[3]);

#endif
