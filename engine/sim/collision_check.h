// collision_check.h - is a body where it may be, and did it get there as it may? Answers by brute force over all
// polygons, for tests and benchmarks; shares no geometry with the body that it checks.
#ifndef WALK_COLLISION_CHECK_H
#define WALK_COLLISION_CHECK_H

#include "visibility/vis.h"

typedef enum CollisionFault {
    COLLISION_NONE,
    COLLISION_OUTSIDE,        // the axis is in no cell, in a window, or at the border of the world
    COLLISION_IN_SOLID,       // a polygon is nearer than the radius
    COLLISION_IN_LEAF,        // a leaf or a closed door is
    COLLISION_THROUGH_SOLID,  // the way of the axis crosses a polygon
    COLLISION_THROUGH_LEAF,   // a leaf or a closed door
    COLLISION_THROUGH_WINDOW,
    COLLISION_FAULTS
} CollisionFault;
extern const char *const COLLISION_FAULT_NAMES[COLLISION_FAULTS];

typedef struct CollisionCheck CollisionCheck;
CollisionCheck *collision_check_new(const CellGraph *graph, Arena *arena);

// Checks a body of this height that stands or falls there. `door_open` is as for vis_query. `what` gets a polygon of the
// graph or an opening, -1 for neither.
CollisionFault collision_check_place(CollisionCheck *check, const float *door_open, Vec3 foot, double height,
                                     int *what);
// One straight piece of the way of a foot, upright or level.
CollisionFault collision_check_way(CollisionCheck *check, const float *door_open, Vec3 from, Vec3 to,
                                   int *what);

// The solid polygons of the graph that may come into a box, each once; until the next call.
int collision_check_near(CollisionCheck *check, Box box, const int **polygons);
// How near a polygon comes to a place in plan, metres; 0 over or under it.
double collision_plan_distance(const Vec3 *vertices, int count, Vec2 at);

#endif
