// near_pairs.h - shares of elements close to a patch, as seen from the whole patch instead of its centre.
//
// A row is computed at a patch's centre. For elements that are far away for the patch's size, the centre is as good as the mean
// over the patch, and the errors of neighbours on a wall cancel. But where a wall meets the floor, the nearest patches would give
// their light to the wrong elements.
#ifndef RADIOSITY_NEAR_PAIRS_H
#define RADIOSITY_NEAR_PAIRS_H

#include "radiosity/factors/form_factor.h"

// The elements of a mesh in the form that the search for near elements uses: for each element a ball around it, and its corners
// without the vertices of neighbours on its straight edges.
typedef struct NearShapes NearShapes;
NearShapes *near_shapes(const Mesh *mesh, Arena *arena);
// To be called when the mesh was posed anew (mesh_pose).
void near_shapes_pose(NearShapes *shapes, const Mesh *mesh);

// The buffers of one thread; all threads may share `shapes`. An element is near a patch if its ball is less than `reach` times the
// patch's radius away from the patch's centre. All memory is taken here.
typedef struct NearPairs NearPairs;
NearPairs *near_pairs_new(const Mesh *mesh, const NearShapes *shapes, double reach, Arena *arena);
// Corrects the row of a patch's centre. The share of each near element is multiplied by the ratio of Lambert's unoccluded form
// factors, the mean over the patch to the one at its centre; the other elements share the rest in proportion. The result is valid
// until the next call.
const Row *near_pairs_row(NearPairs *self, int patch, const Row *row);

#endif
