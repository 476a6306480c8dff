// walk_occlusion.h - how open a point is: ambient occlusion by the walls and furniture near it, computed beforehand.
#ifndef WALK_OCCLUSION_H
#define WALK_OCCLUSION_H

#include "visibility/vis.h"

typedef struct WalkOcclusion WalkOcclusion;

// Walls, low walls and the boxes of furniture occlude; doors move and do not.
WalkOcclusion *walk_occlusion_new(const CellGraph *graph, Arena *arena);

// The open share, 0 .. 1, at a point with normal n (unit), in `region` (-1: in none). `self`: the object that the point is part of,
// which occludes nothing there. May be called by many threads at once.
double walk_occlusion_open(const WalkOcclusion *occlusion, Vec3 point, Vec3 n, int region, int self);

#endif
