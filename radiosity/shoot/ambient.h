// ambient.h - shows unshot light as an even glow, for pictures of a solution that is not complete yet.
#ifndef RADIOSITY_AMBIENT_H
#define RADIOSITY_AMBIENT_H

#include "radiosity/shoot/shoot.h"

// The irradiance from the light that patches have not shot yet, with all its reflections, taken to be the same everywhere indoors,
// W/m^2 a channel.
void ambient_irradiance(const Mesh *mesh, const RadSolution *solution, double out[3]);

// Radiosities with the reflected glow added, into `out` [element_count], W/m^2; the solution itself does not change.
void ambient_radiosities(const Mesh *mesh, const RadSolution *solution, double (*out)[3]);

#endif
