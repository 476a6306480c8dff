// collision_check.h - checks whether a body is at an allowed place and got there by an allowed way. Works by brute force over all
// polygons, for tests and benchmarks; shares no geometry code with the body that it checks.
#ifndef WALK_COLLISION_CHECK_H
#define WALK_COLLISION_CHECK_H

#include "visibility/vis.h"

typedef enum CollisionFault {
    COLLISION_NONE,
    COLLISION_OUTSIDE,        // the axis is in no cell, in a window, or at the border of the world
    COLLISION_IN_SOLID,       // a polygon is nearer than the radius
    COLLISION_IN_LEAF,        // a leaf or a closed door is nearer than the radius
    COLLISION_THROUGH_SOLID,  // the way of the axis crosses a polygon
    COLLISION_THROUGH_LEAF,   // the way of the axis crosses a leaf or a closed door
    COLLISION_THROUGH_WINDOW,
    COLLISION_FAULTS
} CollisionFault;
extern const char *const COLLISION_FAULT_NAMES[COLLISION_FAULTS];

typedef struct CollisionCheck CollisionCheck;
CollisionCheck *collision_check_new(const CellGraph *graph, Arena *arena);

// Checks a body of this height that stands or falls with its foot at `foot`. `door_open` is as for vis_query. `what` receives the
// index of the polygon of the graph or of the opening at fault, -1 for neither.
CollisionFault collision_check_place(CollisionCheck *check, const float *door_open, Vec3 foot, double height,
                                     int *what);
// Checks one straight piece of the path of a foot, vertical or level.
CollisionFault collision_check_way(CollisionCheck *check, const float *door_open, Vec3 from, Vec3 to,
                                   int *what);

// Lists the solid polygons of the graph whose boxes meet `box`, each once, and returns their number. The list is valid until the
// next call.
int collision_check_near(CollisionCheck *check, Box box, const int **polygons);
// The distance of a polygon from the place `at` in plan, metres; 0 where the polygon lies over or under the place.
double collision_plan_distance(const Vec3 *vertices, int count, Vec2 at);

#endif
