// still_light.h - the light that leaves a surface for having been lit, not for mirroring; and what comes straight from lamps: polygons
// that emit, and balls.
#ifndef STILLS_STILL_LIGHT_H
#define STILLS_STILL_LIGHT_H

#include "engine/core/random.h"
#include "engine/stills/still_scene.h"
#include "radiosity/show/reconstruct.h"

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

// The share of the light that leaves a place towards a ball at `to`, of which the horizon hides what is below it.
double still_ball_share(Vec3 normal, Vec3 to, double radius);

typedef struct StillLight {
    const StillScene *scene;
    VertexLight baked;  // of all, or of what was reflected before it came
    StillLamps *lamps;  // NULL: their light is in `baked`
    double mean[3];     // of all surfaces by area, W/m^2
} StillLight;

// `lamps_only`: of the same mesh, what lamps alone do without reflection. Then `baked` is the difference, and what lamps send straight
// comes from `lamps`. NULL, NULL: all is baked.
StillLight still_light_new(const StillScene *scene, const RadSolution *solution,
                           const RadSolution *lamps_only, StillLamps *lamps, Arena *arena);

// The light that a ray sees of it, W/m^2 a channel (of a diffuse surface that looks the same); by so many shadow rays.
void still_light_at(const StillLight *light, const Ray *ray, const SurfaceHit *hit, int rays,
                    StillNumbers *numbers, double out[3]);

#endif
