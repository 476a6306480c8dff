// ray_tree.h - a hierarchy of boxes, eight to a node, over what rays may meet: for rays one by one (those of pictures, which go
// together, have visibility/hidden/ray_tree.h).
#ifndef RAYS_RAY_TREE_H
#define RAYS_RAY_TREE_H

#include "engine/core/lanes.h"
#include "visibility/rays/ray_surfaces.h"

// Items of a leaf, at most.
enum { SURFACE_TREE_LEAF = 3 };

// Bounds of its eight children, each axis: low, high. What a child lacks is a box that nothing meets.
typedef struct SurfaceNode {
    Lane bound[3][2];
    int32_t child[LANES];  // a node, or of a leaf the first in SurfaceTree.items
    int32_t count[LANES];  // of items; 0: a node
} SurfaceNode;

typedef struct SurfaceTree {
    const RaySurfaces *surfaces;
    SurfaceNode *nodes;  // the root first
    int *items;          // leaf by leaf
    int node_count, depth;
} SurfaceTree;

// Keeps `surfaces`, which must stay. Rays may be asked of it from many threads.
SurfaceTree surface_tree_new(const RaySurfaces *surfaces, Arena *arena);

SurfaceHit surface_tree_first(const SurfaceTree *tree, const Ray *ray);
bool surface_tree_blocked(const SurfaceTree *tree, const Ray *ray);  // by anything

#endif
