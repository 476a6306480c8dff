// fill_lamps.h - plain ceiling lamps for rooms that no lamp lights, so that a walk never meets a black room.
#ifndef SCENE_FILL_LAMPS_H
#define SCENE_FILL_LAMPS_H

#include "visibility/vis.h"

// Are lamps added? With the names of both answers.
enum { FILL_LAMPS_OFF, FILL_LAMPS_ON, FILL_LAMPS_STATES };
extern const char *const FILL_LAMPS_NAMES[FILL_LAMPS_STATES];

// Appends emitting squares to the building from which `graph` was made. Lamps of the building's own already have faces
// (lamp_faces.h). A room is a region of kind REGION_ROOM; where a building has no regions, a room is a group of indoor cells that
// portals without doors join. A room has light where a polygon in it emits, or where by day (`day`) an opening without a door leads
// outdoors. A neighbour that shares an opening without a door has light, too; by night where the opening is half of its floor at least.
// All other rooms get lamps, the largest room first. Their flux goes with the floor area: as much per area as the median of rooms with
// lamps of their own. `b` counts the lamps, which a .rad file tells; `rooms` counts the rooms that got any.
void fill_lamps_add(const CellGraph *graph, bool day, Arena *arena, Building *b, int *rooms);

#endif
