// obstacles.h - the solids around a body: the surfaces of the cells that the body is in or reaches into through portals,
// furniture, frames, door leaves where they stand, windows, and the border of the world.
#ifndef WALK_OBSTACLES_H
#define WALK_OBSTACLES_H

#include "engine/sim/solid.h"
#include "visibility/vis.h"

// Only one thread at a time may use an Obstacles. It lives in the arena of obstacles_new and may take more from it, so that the arena must
// stay in its place and belong to that thread; the graph must outlive it.
typedef struct Obstacles Obstacles;
Obstacles *obstacles_new(const CellGraph *graph, Arena *arena);

// The solids around a body. They are stored in the Obstacles that gathered them.
typedef struct Gathered {
    const Solid *solids;  // [solid_count] until the next call
    int solid_count;
    int wall_tests, object_tests;  // surfaces and furniture polygons looked at
} Gathered;

// The solids within `radius` of `at` in plan, between two heights. Surfaces come from `cell` and from the cells reached from it
// through portals that this volume touches, and from no other cell (Oki 3.2). `door_open` is as for vis_query.
Gathered obstacles_gather(Obstacles *obstacles, const float *door_open, int cell, Vec2 at, double radius,
                          Band heights);

// The cell that holds the end of a level or a vertical way, reached from `cell` through portals that the way touches; -1 when the
// way leaves free space by anything but portals, or through a window.
int obstacles_cross(Obstacles *obstacles, int cell, Vec3 from, Vec3 to);

// Is the cell inside a window, which nobody enters?
bool obstacles_is_shut(const Obstacles *obstacles, int cell);

#endif
