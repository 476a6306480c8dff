// near_pairs.h - shares of what is close to a patch, as from all of the patch instead of its centre.
//
// A row is seen from a patch's centre. Of a patch that is far away for its size that is as good as from everywhere on it, and of
// many neighbours on a wall the errors cancel. But where a wall meets the floor the nearest patches give their light
// to the wrong elements.
#ifndef RADIOSITY_NEAR_PAIRS_H
#define RADIOSITY_NEAR_PAIRS_H

#include "radiosity/form_factor.h"

typedef struct NearPairs NearPairs;

// Elements within `reach` radii of a patch are taken to be near it. All memory is taken here.
NearPairs *near_pairs_new(const Mesh *mesh, double reach, Arena *arena);
// The row of a patch's centre, with the shares of near elements multiplied by what Lambert's formula says of the mean over
// the patch and of its centre, were nothing between; what is left goes to the others in proportion. Valid until the next.
const Row *near_pairs_row(NearPairs *self, int patch, const Row *row);

#endif
