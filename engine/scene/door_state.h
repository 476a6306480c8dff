// door_state.h - how far doors are open, as users say it.
#ifndef SCENE_DOOR_STATE_H
#define SCENE_DOOR_STATE_H

#include "maps/building/building.h"

// How far each opening of a building is open, [opening_count], as it is drawn; 1 for openings without a door.
float *door_state_drawn(const Building *building, Arena *arena);

// Applies a sentence such as "closed,salon=open,front=40%" (state_parts.h) to a state `open` [opening_count]. Before each `=` stands a
// door's name or `all`. After it stand `open`, `closed`, `drawn`, or a share of the door's way, 0 to 1 or with % after it. Fails with a
// sentence that names the part, what was found and what is allowed.
bool door_state_apply(const Building *building, const char *sentence, float *open, Error *error);

#endif
