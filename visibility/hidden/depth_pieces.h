// depth_pieces.h - parts of facets in the picture: which hides which, and cuts.
#ifndef VISIBILITY_DEPTH_PIECES_H
#define VISIBILITY_DEPTH_PIECES_H

#include "visibility/hidden/image.h"

typedef struct DepthPiece {
    int facet, order;
    int first, count;          // in DepthPieces.corners and .edges
    int next;                  // in a list of its owner
    double x0, x1, y0, y1;     // of its corners, pixels
    double nearest, farthest;  // 1/z of its corners: most and least
    Line depth;
} DepthPiece;

typedef struct DepthPieces {
    DepthPiece *piece;  // [count]
    Vec2 *corners;      // [corner_count] pixels
    Line *
        edges;  // [corner_count] from a corner to the next; lane 3: 1 / length of (a, b), so that it tells pixels
    int count, corner_count;
    Arena *arena;
    int capacity, corner_capacity, edge_capacity;
} DepthPieces;

// A shape of the picture, clipped to it.
void depth_pieces_add(DepthPieces *pieces, const Picture *picture, const Shape *shape);

// Does it hide some of the other, so that it may not be painted before it?
bool depth_pieces_hides(const DepthPieces *pieces, int piece, int other);

// Cuts a piece in two along a line of the picture; false where that leaves nothing on one side.
bool depth_pieces_cut(DepthPieces *pieces, int piece, Line line, int parts[2]);

#endif
