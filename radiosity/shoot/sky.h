// sky.h - daylight: the sky by its radiance in each direction, the ground beyond the building's, and the sun.
#ifndef RADIOSITY_SKY_H
#define RADIOSITY_SKY_H

#include "radiosity/shoot/shoot.h"

// Looks at the sky from all elements outdoors, and from all openings, that are kept for other hours (RadOptions.sky): the next light of
// the day takes what is there. The mesh and all else that is given must outlive them. To be ended.
SkyLooks *sky_looks_new(const Mesh *mesh, const StabForest *forest, const float *door_open,
                        const RadOptions *options);
void sky_looks_end(SkyLooks *looks);
// Doors have moved: the mesh is posed already (mesh_move), and so is the caller's `door_open`. Drops the looks that may see one of these.
void sky_looks_move(SkyLooks *looks, const MovedDoors *moved);

// Adds the direct light of a day to the radiosities and the unshot light of a solution in which nothing was shot yet; the light that
// comes in counts as emitted. Neither culling nor the number of threads changes the result.
// False where progress asked to stop: the solution is then incomplete and must not be used.
bool rad_shine(const Mesh *mesh, const StabForest *forest, const float *door_open, const RadOptions *options,
               const Daylight *day, const Progress *progress, RadSolution *solution);

#endif
