// fresnel.h - light at the smooth surface between two clear media.
#ifndef CORE_FRESNEL_H
#define CORE_FRESNEL_H

#include <math.h>

// The shares of light that are reflected, of the two polarisations: across the plane of incidence, and within it (Fresnel 1823; Hecht,
// Optics, section 4.6.2). `ratio` is the index of refraction beyond the surface over the index before it; `cosine` is that of the angle to
// the normal, 0 .. 1. Returns the cosine beyond the surface; 0, and both shares 1: total reflection.
static inline double fresnel_shares(double cosine, double ratio, double share[2]) {
    double sine2 = (1 - cosine * cosine) / (ratio * ratio);
    share[0] = share[1] = 1;
    if (sine2 >= 1) return 0;
    double beyond = sqrt(1 - sine2);
    double across = (cosine - ratio * beyond) / (cosine + ratio * beyond);
    double within = (ratio * cosine - beyond) / (ratio * cosine + beyond);
    share[0] = across * across;
    share[1] = within * within;
    return beyond;
}

#endif
