// ambient.h - light that is still on its way, as an even glow: the picture of a solution that is not complete yet.
#ifndef RADIOSITY_AMBIENT_H
#define RADIOSITY_AMBIENT_H

#include "radiosity/shoot/shoot.h"

// The light that patches have not shot yet, as it arrives everywhere indoors, with all its reflections, W/m^2 a channel.
void ambient_irradiance(const Mesh *mesh, const RadSolution *solution, double out[3]);

// Radiosities with the glow that they reflect, [element_count], for show: the solution itself knows nothing of it.
void ambient_radiosities(const Mesh *mesh, const RadSolution *solution, double (*out)[3]);

#endif
