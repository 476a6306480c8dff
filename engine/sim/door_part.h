// door_part.h - the parts of a door that obstruct a body: its leaves where they stand, and whether its frame lets a body pass.
#ifndef WALK_DOOR_PART_H
#define WALK_DOOR_PART_H

#include "engine/sim/solid.h"
#include "visibility/vis.h"

// A leaf, or the line of a door without leaves.
typedef struct DoorPart {
    Vec2 plan[LEAF_CORNERS];  // counter-clockwise
    int count;                // 2 for a line
    Band heights;
} DoorPart;

int door_part_count(const Building *building, int opening);  // 0 for passages and windows
// The part as it stands when the door is at share `open` of its way. A door without leaves is an obstacle only while closed: false
// when it is open.
bool door_part(const Building *building, int opening, int part, double open, DoorPart *out);
// The part as a solid, whose vertices are stored in `plan` [LEAF_CORNERS].
Solid door_part_solid(const DoorPart *part, Vec3 *plan);
// A box around all places that a leaf reaches on its way.
Box door_leaf_reach(const Leaf *leaf);

// Can a body's disc pass the door when it is wide open? With its frame as drawn, or without a frame.
bool door_lets_pass(const CellGraph *graph, int opening, bool with_frame);

#endif
