// tour_floor.h - the floors that a walking body can stand on, as a grid of places linked by the steps that the body takes.
//
// Every link was walked by a body of body.h with all doors wide open, both ways: stairs, sills, low beams and leaves count as they
// do for a person. Places that are linked, however far, are one part of the building.
#ifndef WALK_TOUR_FLOOR_H
#define WALK_TOUR_FLOOR_H

#include "engine/sim/body.h"

// Ways a place may be unfit for a film, though a body can stand there.
enum {
    FLOOR_LOW = 1,        // the body ducks
    FLOOR_ON_THINGS = 2,  // it stands on furniture
    FLOOR_IN_THINGS = 4,  // the eye is in the stand-in box of a piece of furniture
    FLOOR_OUTSIDE = 8     // outdoors
};

typedef struct FloorPlace {
    Vec3 foot;
    float eye;        // over the foot, metres
    float clearance;  // to the nearest place without a way on, metres; at most FLOOR_CLEAR
    int cell, part;
    int next;     // another place of the same column, -1: none
    int link[8];  // the places one step along +x, +x+y, +y, ... counter-clockwise; -1: none
    unsigned char unfit;
} FloorPlace;
#define FLOOR_CLEAR 2.0

// Read only once it is made. It lives in the arena of tour_floor_make.
typedef struct TourFloor {
    const CellGraph *graph;
    FloorPlace *places;  // [place_count]
    int *column;         // [nx * ny] the first place over each point of the grid, -1: none
    Vec2 origin;
    double apart;  // of neighbouring columns, metres: 0.1, more where the building is large
    int nx, ny, place_count, place_capacity, part_count;
    int *part_size;         // [part_count] places
    unsigned char *chosen;  // [cell_count] the cells that the tour may enter; NULL: all
} TourFloor;

// `rooms`: the floors of at most so many rooms, those with the shortest ways from the start, and of doorways and stairs there, in a
// building of regions; 0: of the whole building.
void tour_floor_make(const CellGraph *graph, int rooms, Arena *arena, TourFloor *out);
// The place nearest to `foot` in plan within two columns and at most a step higher or lower; -1: none.
int tour_floor_at(const TourFloor *floor, Vec3 foot);

// Are places linked all along the straight line in plan from a foot to another, each with at least `clearance`, metres, and nothing of
// `unfit`?
bool tour_floor_straight(const TourFloor *floor, Vec3 from, Vec3 to, double clearance, unsigned unfit);

// Is an eye in the stand-in box of a piece of furniture, or nearer than `grow` metres to it?
bool tour_floor_in_things(const Building *building, Vec3 eye, double grow);

#endif
