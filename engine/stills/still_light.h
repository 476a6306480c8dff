// still_light.h - the diffuse light that leaves a surface, without mirrored light; and the light that comes straight from lamps, which are
// polygons that emit, and balls.
#ifndef STILLS_STILL_LIGHT_H
#define STILLS_STILL_LIGHT_H

#include "engine/core/random.h"
#include "engine/stills/still_scene.h"
#include "radiosity/show/reconstruct.h"

// A sequence of points that fill the three-dimensional unit cube evenly (Roberts 2018, The Unreasonable Effectiveness of Quasirandom
// Sequences), shifted by a vector of each pixel's own.
typedef struct StillNumbers {
    double shift[3];
    int next;
} StillNumbers;

typedef struct StillLamps StillLamps;
// `forest` tells which lamps a cell may see; NULL: all. `samples`: of a pixel; with more of them, more looks to the lamps are worth their
// time beforehand.
StillLamps *still_lamps_new(const StillScene *scene, const StabForest *forest, int samples, Arena *arena);
void still_lamps_end(StillLamps *lamps);
int still_lamps_count(const StillLamps *lamps);

// The share of the light leaving a place that would meet a ball at `to` (relative to the place), without the part below the horizon.
double still_ball_share(Vec3 normal, Vec3 to, double radius);

typedef struct StillLight {
    const StillScene *scene;
    VertexLight baked;  // all light, or the light that was reflected on its way
    StillLamps *lamps;  // NULL: their light is in `baked`
    Daylight sun;       // its disc lights places by shadow rays; no beam: the sun's light is in `baked`
    Vec3 sun_x, sun_y;  // unit vectors across its beam
    double mean[3];     // mean of all surfaces by area, W/m^2
    double outdoors;    // light of surfaces outdoors is shown by this factor
} StillLight;

// With `lamps`, light straight from lamps comes from these, that of the sun from its disc, and `baked` is the rest of the solution. The
// sun's light stays baked where the solution has no light at nodes. NULL: all light is baked.
StillLight still_light_new(const StillScene *scene, const RadSolution *solution, StillLamps *lamps,
                           Arena *arena);

// The light that a ray sees at its hit, W/m^2 a channel (the radiosity of a diffuse surface that looks the same), of a picture as of
// its mean over about `width` metres; times `outdoors` where outdoors is in front of the surface. Takes about `rays` shadow rays.
void still_light_at(const StillLight *light, const Ray *ray, const SurfaceHit *hit, double width, int rays,
                    StillNumbers *numbers, double out[3]);

#endif
