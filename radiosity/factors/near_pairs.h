// near_pairs.h - shares of elements close to a patch, as from all of the patch instead of its centre.
//
// A row is seen from a patch's centre. Of a patch that is far away for its size that is as good as from everywhere on it, and of
// many neighbours on a wall the errors cancel. But where a wall meets the floor the nearest patches give their light
// to the wrong elements.
#ifndef RADIOSITY_NEAR_PAIRS_H
#define RADIOSITY_NEAR_PAIRS_H

#include "radiosity/factors/form_factor.h"

// The elements of a mesh as near ones are told by: each in a ball, and its corners without those that do not turn, where neighbours
// meet its edges.
typedef struct NearShapes NearShapes;
const NearShapes *near_shapes(const Mesh *mesh, Arena *arena);

// One thread's; shapes are for all of them. Elements within `reach` radii of a patch are taken to be near it. All memory is taken
// here.
typedef struct NearPairs NearPairs;
NearPairs *near_pairs_new(const Mesh *mesh, const NearShapes *shapes, double reach, Arena *arena);
// The row of a patch's centre, with the shares of near elements multiplied by what Lambert's formula says of the mean over
// the patch and of its centre, were nothing between; the rest goes to the others in proportion. Valid until the next.
const Row *near_pairs_row(NearPairs *self, int patch, const Row *row);

#endif
