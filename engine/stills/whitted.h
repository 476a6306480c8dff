// whitted.h - traces the tree of rays that mirrors and glass make of each ray from the eye.
#ifndef STILLS_WHITTED_H
#define STILLS_WHITTED_H

#include "engine/stills/still_light.h"

typedef struct Whitted {
    const StillScene *scene;
    const StillLight *light;
    int depth;         // the most rays in one chain, 1 ..
    double threshold;  // a ray whose weight in the pixel is less is not followed
    double
        spread;  // the angle between neighbouring rays from the eye, radians; pictures are averaged over it
    int lamp_rays;  // shadow rays for a surface that is seen directly
    // The light where a ray meets nothing, W/m^2 a channel; NULL: dark.
    void (*sky)(const void *context, Vec3 direction, double out[3]);
    const void *sky_context;
} Whitted;

// How many rays were traced, and how many ended for which reason.
typedef struct WhittedWork {
    long long rays;
    long long matt, escaped, faint,
        deep;  // a surface that neither mirrors nor refracts; nothing met; threshold; depth
} WhittedWork;

// The light that a ray in `media` sees, W/m^2 a channel. Random numbers depend on `seed`, the pixel's, and on `sample` (its number) alone.
void whitted_trace(const Whitted *whitted, const Ray *ray, const Media *media, uint64_t seed, int sample,
                   WhittedWork *work, double out[3]);

#endif
