// tour_route.h - the way of a tour over the floors: which rooms in which order, and a smooth line through them.
#ifndef WALK_TOUR_ROUTE_H
#define WALK_TOUR_ROUTE_H

#include "engine/tour/tour_floor.h"

// A point of the line on which the eye goes.
typedef struct RoutePoint {
    Vec3 eye;
    double foot;  // height of the floor, metres
    int room;     // see TourRoute.room_name; -1: in a doorway, on a stair's landing, outdoors
} RoutePoint;

// Lines of points ROUTE_APART metres apart; from the end of one to the start of the next no body can walk.
#define ROUTE_APART 0.1
typedef struct TourRoute {
    RoutePoint *points;  // [point_count]
    int *leg_first;      // [leg_count + 1] leg i is points[leg_first[i]] ..
    int point_count, point_capacity, leg_count;
    // Rooms: regions of one name that touch count as one. In a building without regions, pieces of floor some metres across.
    const char **room_name;  // [room_count] "" where it has none
    Vec3 *room_place;        // [room_count] a foot in it
    // ROOM_SHUT: no body can stand in it, or only where there is no room to take a step. ROOM_BEYOND: it was not asked for.
    enum { ROOM_SHUT, ROOM_OPEN, ROOM_ENTERED, ROOM_BEYOND } * room_state;
    int room_count;
    bool moved;  // the start of the building is in a place without a way out: the first leg is elsewhere
} TourRoute;

// The first leg begins at the start of the building or, where few rooms can be reached from there, in the largest part; the other
// parts follow, the largest first.
void tour_route_make(const TourFloor *floor, Arena *arena, TourRoute *out);

#endif
