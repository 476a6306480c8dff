// sky.h - daylight: a sky of the same radiance everywhere above the horizon; no light comes from below.
#ifndef RADIOSITY_SKY_H
#define RADIOSITY_SKY_H

#include "radiosity/shoot/shoot.h"

// Adds the direct light of a sky of `radiance`, W/m^2/sr a channel, to the radiosities and the unshot light of a solution in which
// nothing was shot yet; the light that comes in counts as emitted. Neither culling nor the number of threads changes the result.
// False where progress asked to stop: the solution is then incomplete and must not be used.
bool rad_shine(const Mesh *mesh, const StabForest *forest, const float *door_open, const RadOptions *options,
               const double radiance[3], const Progress *progress, RadSolution *solution);

#endif
