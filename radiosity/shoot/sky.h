// sky.h - daylight: a sky of the same radiance all over, above the horizon; nothing comes from below.
#ifndef RADIOSITY_SKY_H
#define RADIOSITY_SKY_H

#include "radiosity/shoot/shoot.h"

// Adds what the sky sends directly, of radiance W/m^2/sr a channel, to a solution in which nothing was shot: radiosities and what
// is unshot; what was emitted grows by what comes in. Culling does not change the result, nor does the number of threads. False
// where progress asked to stop: what has come in by then is no solution.
bool rad_shine(const Mesh *mesh, const StabForest *forest, const float *door_open, const RadOptions *options,
               const double radiance[3], const Progress *progress, RadSolution *solution);

#endif
