// exposure.h - how bright what is seen is, and how the eye adapts to it in time.
#ifndef WALK_EXPOSURE_H
#define WALK_EXPOSURE_H

#include "engine/draw/lit_mesh.h"
#include "visibility/hidden/hidden.h"

typedef struct Exposure {
    bool fixed;    // the eye no longer adapts
    double stops;  // brighter by so many powers of two
    double level;  // what the eye has adapted to, W/m^2 by light_luminous; 0: nothing was seen yet
} Exposure;
enum { EXPOSURE_STOPS_MOST = 8 };

// The logarithmic mean of what is seen of these objects, each place by how large it is to the eye and by the root of its light; 0: nothing
// is lit. A function of the view alone.
double exposure_meter(const LitMesh *lit, const LitLight *light, const Camera *camera, const int *objects,
                      int object_count);
// Time goes on, seconds, before what the meter says in a building of the level `usual`. The first time the eye adapts at once.
void exposure_adapt(Exposure *exposure, double seen, double usual, double seconds);
// The factor of radiosities, m^2/W.
double exposure_scale(const Exposure *exposure);

#endif
