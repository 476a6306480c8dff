// door_states.h - how the doors of a building stand when a walk begins.
#ifndef WALK_DOOR_STATES_H
#define WALK_DOOR_STATES_H

#include "engine/core/random.h"
#include "maps/building/building.h"

typedef enum WalkDoors {
    WALK_DOORS_OPEN,
    WALK_DOORS_CLOSED,
    WALK_DOORS_DRAWN,   // as the file has them
    WALK_DOORS_RANDOM,  // at any angle
    WALK_DOORS          // not said
} WalkDoors;
extern const char *const WALK_DOORS_NAMES[WALK_DOORS];

// How far one door is open, as for vis_query. Every call advances `random`, whatever `doors` is.
float walk_door_share(const Building *building, int opening, WalkDoors doors, Random *random);
// Moves each door behind whose leaf, or in whose leaf, stored viewpoints are: to the share at which fewest are, of `door_open`, wide
// open, closed and as drawn. `door_open` [opening_count] is as for vis_query.
void walk_clear_views(const Building *building, float *door_open);
// A random share: closed, wide open, or anything between, including hardly open.
float walk_random_share(Random *random);

#endif
