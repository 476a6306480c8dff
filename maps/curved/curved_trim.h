// curved_trim.h - a trimmed patch while it is cut into polygons.
#ifndef MAPS_CURVED_TRIM_H
#define MAPS_CURVED_TRIM_H

#include "maps/curved/curved_patch.h"
#include "maps/curved/curved_tessellate.h"

// Of the polylines that the loops became, in parameters; within a cell of the grid.
typedef struct TrimSegment {
    Vec2 a, b;
} TrimSegment;

typedef struct TrimPiece {
    Vec2 corner[4];
    int count;
} TrimPiece;

typedef struct CurvedTrimmed {
    const CurvedControl *control;
    CurvedControl border[4][4];
    int border_steps[4];
    double tolerance;
    int nu, nv;
    double *u, *v;  // [nu + 1], [nv + 1] the lines of the grid
    TrimSegment *segments;
    TrimPiece *pieces;
    Vec2 *by_u, *by_v;  // [corner_count] all corners of pieces, by u and then v, by v and then u
    int segment_count, segment_capacity, piece_count, piece_capacity, corner_count;
    Arena *arena;
    CurvedMesh *out;
} CurvedTrimmed;

// curved_trim_pieces.c: fills `pieces` and `corner_count`; false where there would be too many.
bool curved_trim_cut(CurvedTrimmed *t);

#endif
