// ray_tree_build.h - what those share who make the tree and those who go through it.
#ifndef RAYS_RAY_TREE_BUILD_H
#define RAYS_RAY_TREE_BUILD_H

// Nodes on top of one another, at most. Where splits by cost go deeper than half of that, the rest is halved by count: 31 times
// at most.
enum { SURFACE_TREE_DEEPEST = 64 };

#endif
