// collision_flood.h - every place of a plan grid that can be reached by foot, storeys and stairs included:
// what a walking body is held against.
#ifndef WALK_COLLISION_FLOOD_H
#define WALK_COLLISION_FLOOD_H

#include "engine/sim/collision_check.h"

// Distance of neighbouring places, metres: a quarter of the radius of a body.
#define FLOOD_APART 0.05
// Outdoors only so far from anything built, metres: beyond is nothing to meet.
#define FLOOD_OUTDOORS 2.0

typedef struct FloodRules {
    double radius, spare;   // metres: of the disc that is carried, and how much more of it is kept clear
    double step, headroom;  // metres
    bool leaves;            // of doors, wide open, are in the way
    bool strict;            // only even ground, and no way down that does not lead up again
} FloodRules;
// Where a body surely gets: 2 cm of room to spare, which the straight ways between neighbours need: a disc of 0.2 m stays
// within two of 0.22 m, 5 cm apart, all the way from one to the other.
FloodRules flood_strict(void);
// Where a body may get at all: a disc so small that it is free at the grid's place nearest to any free body.
FloodRules flood_loose(void);

typedef struct FloodPlace {
    Vec3 foot;
    double middle;  // the height of what carries the middle of the disc
    double ceiling;
    int link[4];  // the place that a step along +x, +y, -x, -y leads to, -1 none
    int next;     // of the same column, -1 none
} FloodPlace;

typedef struct CollisionFlood {
    FloodPlace *places;
    int *column;  // [nx * ny] its first place, -1 none
    Vec2 origin;
    int nx, ny, place_count, place_capacity;
} CollisionFlood;

// From the floor in the middle of every cell: furniture and closed corners part what one start would reach.
CollisionFlood collision_flood(CollisionCheck *check, const CellGraph *graph, const FloodRules *rules,
                               Arena *arena);
// Is a place of the flood within `reach` in plan and `rise` in height? True outside the grid, which says nothing there.
bool collision_flood_near(const CollisionFlood *flood, Vec3 foot, double reach, double rise);

#endif
