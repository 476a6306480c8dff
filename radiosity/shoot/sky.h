// sky.h - daylight: the sky by its radiance in each direction, the ground beyond the building's, and the sun.
#ifndef RADIOSITY_SKY_H
#define RADIOSITY_SKY_H

#include "radiosity/shoot/shoot.h"

// Adds the direct light of a day to the radiosities and the unshot light of a solution in which nothing was shot yet; the light that
// comes in counts as emitted. Neither culling nor the number of threads changes the result.
// False where progress asked to stop: the solution is then incomplete and must not be used.
bool rad_shine(const Mesh *mesh, const StabForest *forest, const float *door_open, const RadOptions *options,
               const Daylight *day, const Progress *progress, RadSolution *solution);

#endif
