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

// convex_sweep.c: triangles of the polygon whose edges run from edges[i][0] to edges[i][1] with its inside on their left; `at` are
// points on a grid, the same place may have several. Returns how many triangles there are, three points each, counter-clockwise; -1
// where the edges are no polygon.
int convex_sweep(const Vec2 *at, const int (*edges)[2], int count, Arena *arena, int **triangles);

#endif
