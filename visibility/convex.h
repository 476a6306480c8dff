// convex.h - a plan polygon with holes, cut into convex pieces of its own vertices.
#ifndef VISIBILITY_CONVEX_H
#define VISIBILITY_CONVEX_H

#include "engine/core/arena.h"
#include "engine/core/error.h"
#include "engine/core/vec.h"

typedef struct ConvexPieces {
    int *vertex;  // indices into the points given, each piece counter-clockwise
    int *first;   // [count + 1]
    int count;
} ConvexPieces;

// Rings as in Region: ring r is points[ring_first[r]] .. ; the first is the outer one, counter-clockwise, the rest
// are holes. Pieces may have collinear vertices. Fails when the rings are no polygon.
bool convex_decompose(const Vec2 *points, const int *ring_first, const int *ring_size, int ring_count,
                      Arena *arena, ConvexPieces *out, Error *error);

#endif
