// sunlight.h - the share of the sun's light that each element has, by exact clipping.
#ifndef RADIOSITY_SUNLIGHT_H
#define RADIOSITY_SUNLIGHT_H

#include "radiosity/daylight/daylight.h"
#include "radiosity/mesh/mesh.h"

// Stores in `share` [mesh->element_count] the part of each element's area that sees the sun's middle, 0 .. 1, along the unit vector
// `sun`, times the share of its light that passes the panes before it (panes.h): 0 for elements that face away. `cells_alone`: surfaces
// of cells that no beam of the sun reaches through portals are passed over, which changes no result. The number of threads changes none
// either.
void sunlight_shares(const Mesh *mesh, Vec3 sun, bool cells_alone, int threads, double *share);

// The radiosity that the sun causes on each element, as rad_shine adds it, W/m^2 a channel, into `out` [mesh->element_count].
void sunlight_elements(const Mesh *mesh, const Daylight *day, int threads, double (*out)[3]);

// The cells of the mesh's graph [cell_count] into which a sun of this radius, radians, may shine: those outdoors, and those that its
// beams reach through portals. Allocated in the arena.
bool *sunlight_cells(const Mesh *mesh, Vec3 sun, double radius, Arena *arena);

#endif
