// exposure.h - measures how bright a view is, and adapts the exposure to it over time, as an eye does.
#ifndef WALK_EXPOSURE_H
#define WALK_EXPOSURE_H

#include "engine/lit/lit_mesh.h"
#include "visibility/hidden/hidden.h"

typedef struct Exposure {
    bool fixed;    // the eye no longer adapts
    double stops;  // the picture is brighter by so many powers of two
    double level;  // the brightness the eye has adapted to, W/m^2 by light_luminous; 0: nothing was seen yet
} Exposure;
enum { EXPOSURE_STOPS_MOST = 8 };

// The logarithmic mean of the light of these objects' elements in view, W/m^2 by light_luminous; each element is weighted by its solid
// angle at the eye and by the root of its light. 0: nothing in view is lit. The same view has the same mean.
double exposure_meter(const LitMesh *lit, const LitLight *light, const Camera *camera, const int *objects,
                      int object_count);
// Lets the eye adapt for so many seconds to `seen`, a result of exposure_meter, in a building of the level `usual` (LitLight.level). At the
// first call the eye adapts at once. True while the eye is still on its way to a level that looks different.
bool exposure_adapt(Exposure *exposure, double seen, double usual, double seconds);
// The factor by which radiosities are multiplied for the screen, m^2/W.
double exposure_scale(const Exposure *exposure);
// That factor for what lies outdoors under such a day. Where a room is dark beside the day, eyes adapt to either by itself: what is seen
// through a window is bright, and keeps its colours. Outdoors, and by night, both are one.
double exposure_outdoors(double scale, const Daylight *day);
// A channel of light, times that factor, on the screen: sRGB, 0 .. 1, by the curve of walk_shade.h.
double exposure_on_screen(double light);

#endif
