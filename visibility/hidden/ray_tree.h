// ray_tree.h - a bounding-volume hierarchy over facets: two children to a node and boxes in doubles, through which 8 x 8 rays go
// together. That of visibility/rays is for one ray, which meets eight children at once.
#ifndef VISIBILITY_RAY_TREE_H
#define VISIBILITY_RAY_TREE_H

#include "visibility/hidden/facets.h"

// Facets of a leaf, at most: so many are tested without looking for a better split.
enum { TREE_LEAF = 4 };
// Deeper than this the hierarchy is halved by count, which ends within 31 more levels.
enum { TREE_DEEP = 40, TREE_STACK = TREE_DEEP + 40 };

// Inner: children at `first` and `first + 1`, count 0. Leaf: places first .. first + count - 1 of RayTree.facet.
typedef struct TreeNode {
    Box box;
    int first, count;
} TreeNode;

typedef struct RayTree {
    TreeNode *nodes;  // [node_count], the root first
    int *facet;       // [facet_count] indices of facets, leaf by leaf
    Box *box;         // [facet_count] of Facets.facets
    int node_count;
} RayTree;

RayTree ray_tree_new(const Facets *facets, Arena *arena);

#endif
