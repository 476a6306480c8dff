// tour_rooms.h - which places of the floor belong to which room.
#ifndef WALK_TOUR_ROOMS_H
#define WALK_TOUR_ROOMS_H

#include "engine/tour/tour_route.h"

// Fills the rooms of `out`, all shut or open, and returns [place_count] the room of each place, -1 in none. A place on furniture is
// in no room, nor is one of a part too small to walk in.
int *tour_rooms_find(const TourFloor *floor, Arena *arena, TourRoute *out);

#endif
