// still_light.h - the light that leaves a surface for having been lit, not for mirroring.
#ifndef STILLS_STILL_LIGHT_H
#define STILLS_STILL_LIGHT_H

#include "engine/stills/still_lamps.h"
#include "radiosity/show/reconstruct.h"

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
