// bsp_tree.h - facets cut along their own planes until every pair has an order from every eye.
#ifndef VISIBILITY_BSP_TREE_H
#define VISIBILITY_BSP_TREE_H

#include "visibility/hidden/facets.h"

// Part of a facet.
typedef struct BspPiece {
    int facet, first, count;  // in BspTree.corners and .edges
} BspPiece;

typedef struct BspNode {
    Plane plane;                   // building space
    int child[2];                  // behind the plane, before it; -1: none
    int first_piece, piece_count;  // in the plane, the last of the list first
} BspNode;

// An edge of a piece is an edge of its facet (its number, >= 0), or the cut by a node's plane: bsp_cut.
static inline int bsp_cut(int node, int side) { return -1 - (2 * node + side); }
static inline int bsp_cut_node(int edge) { return (-1 - edge) / 2; }
static inline int bsp_cut_side(int edge) { return (-1 - edge) % 2; }  // the piece's: 0 behind, 1 before

typedef struct BspTree {
    BspNode *nodes;    // [node_count], the root first
    BspPiece *pieces;  // [piece_count]
    Vec3 *corners;     // [corner_count]
    int *edges;        // [corner_count] from a corner to the next
    int node_count, piece_count, corner_count;
    int most_edges, splits, depth;
} BspTree;

BspTree bsp_tree_new(const Facets *facets, Arena *arena);

#endif
