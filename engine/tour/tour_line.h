// tour_line.h - a chain of neighbouring places of the floor as a smooth line for the eye.
#ifndef WALK_TOUR_LINE_H
#define WALK_TOUR_LINE_H

#include "engine/tour/tour_route.h"

typedef struct WayPlace {
    int place;
    bool stays;  // the line stays in the room of this place
} WayPlace;

// Adds the line along `way` [count] to the points of `out`. `room_of` [place_count] is from tour_rooms_find.
void tour_line_add(const TourFloor *floor, const int *room_of, const WayPlace *way, int count, Arena *arena,
                   TourRoute *out);

#endif
