// still_lamps.h - the light that comes straight from lamps: polygons that emit, and balls.
#ifndef STILLS_STILL_LAMPS_H
#define STILLS_STILL_LAMPS_H

#include "engine/core/random.h"
#include "engine/stills/still_scene.h"

// One number after another that fill three dimensions evenly (Roberts 2018, The Unreasonable Effectiveness of Quasirandom Sequences),
// from a place that is each pixel's own.
typedef struct StillNumbers {
    double shift[3];
    int next;
} StillNumbers;

typedef struct StillLamps StillLamps;
// Which lamps a cell may see the forest tells; NULL: all. For pictures of so many samples a pixel: more of them are worth more care
// beforehand.
StillLamps *still_lamps_new(const StillScene *scene, const StabForest *forest, int samples, Arena *arena);
void still_lamps_end(StillLamps *lamps);
int still_lamps_count(const StillLamps *lamps);

// A place before whose surface one asks for light.
typedef struct StillPlace {
    Vec3 point, normal;
    int element;  // of the mesh, on which it lies or near which
    bool front;   // of it
} StillPlace;

// The irradiance that lamps send there, W/m^2 a channel: what would arrive if nothing stood between, in closed form, times the share
// that is seen of it, by `rays` shadow rays.
void still_lamps_light(StillLamps *lamps, const StillPlace *place, int rays, StillNumbers *numbers,
                       double out[3]);

// The share of the light that leaves a place towards a ball at `to`, of which the horizon hides what is below it.
double still_ball_share(Vec3 normal, Vec3 to, double radius);

#endif
