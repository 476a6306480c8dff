// bezier_patch.h - a rational bicubic Bezier patch made ready for rays: cut into nearly flat pieces, in a tree of boxes.
#ifndef RAYS_BEZIER_PATCH_H
#define RAYS_BEZIER_PATCH_H

#include "engine/core/lanes.h"
#include "maps/building/building.h"
#include "visibility/bezier/bezier_trim.h"

// Four rows of v, lanes along u; points about the patch's centre, multiplied by their weights.
typedef struct PatchNet {
    Four x[4], y[4], z[4], w[4];
} PatchNet;

typedef struct PatchPiece {
    PatchNet net;
    double u, v, width_u, width_v;  // the part of the patch it is
    bool trimmed;                   // some of it is cut off
} PatchPiece;

// Up to four parts of a patch, each a node or, as ~ of its index, a piece.
typedef struct PatchNode {
    Four low[3], high[3];  // x, y, z of their boxes, about the patch's centre
    int child[4];
    int count;
} PatchNode;

enum { PATCH_DEPTH = 5 };  // of the tree, at most: 4^5 pieces

typedef struct BezierPatch {
    Vec3 centre;
    double size;       // from corner to corner of its control points' box
    PatchNode *nodes;  // [node_count] nodes[0]: the root
    PatchPiece *pieces;
    int node_count, node_capacity, piece_count, piece_capacity;
    Trim *trim;  // NULL: all of it is there
    Box box;
} BezierPatch;

// `whole`: in one piece, as it is.
BezierPatch *bezier_patch_new(const Building *building, const CurvedShape *shape, bool whole, Arena *arena);

// The four Bernstein polynomials of degree 3, and their derivatives.
static inline Four bezier_basis(double s) {
    double r = 1 - s;
    return (Four){r * r * r, 3 * r * r * s, 3 * r * s * s, s * s * s};
}
static inline Four bezier_slopes(double s) {
    double r = 1 - s;
    return (Four){-3 * r * r, 3 * r * (r - 2 * s), 3 * s * (2 * r - s), 3 * s * s};
}
static inline Four bezier_bends(double s) {
    double r = 1 - s;
    return (Four){6 * r, 6 * (s - 2 * r), 6 * (r - 2 * s), 6 * s};
}

static inline Four bezier_over_rows(const Four row[4], Four basis) {
    return (basis[0] * row[0] + basis[1] * row[1]) + (basis[2] * row[2] + basis[3] * row[3]);
}

// A matrix restricts coefficients to low .. high: of[i] are the shares of the old ones in new coefficient i.
typedef struct BezierCut {
    double of[4][4];
} BezierCut;
BezierCut bezier_cut(double low, double high);
// New rows from old ones; new lanes from old ones.
void bezier_cut_rows(Four row[4], const BezierCut *cut);
void bezier_cut_lanes(Four row[4], const BezierCut *cut);
// The point of a net, about the patch's centre, and its derivatives.
typedef struct PatchPoint {
    Vec3 p, du, dv;
} PatchPoint;
PatchPoint bezier_patch_point(const PatchNet *net, double u, double v);

#endif
