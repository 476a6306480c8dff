// room_grid.h - the points of a room at which a planner measures light.
#ifndef RADIOSITY_ROOM_GRID_H
#define RADIOSITY_ROOM_GRID_H

#include "engine/core/arena.h"
#include "maps/building/building.h"

// Cells of one size over a room, along its longest wall; each has a point in its middle where that is in the room and not in the strip
// beside the walls.
typedef struct RoomGrid {
    Vec2 origin, x, y;  // plan: a corner of the grid, and unit vectors along its sides
    double step[2];     // metres, of a cell along x and y
    int count[2];       // of cells along x and y
    int *point;    // [count[0] * count[1]] row by row along x, the index of a cell's point; -1: it has none
    Vec2 *points;  // [point_count] plan
    int point_count;
    double border;  // of the strip beside the walls, metres; 0: the room is too narrow for one
} RoomGrid;

// The largest spacing for an area whose side is `d`, metres (EN 12464-1: 0.2 * 5^(log10 d), at most 10).
double room_grid_spacing(double d);
// The grid of EN 12464-1: the side that tells the spacing is the longer one, or the shorter one where it is half as long or less; the strip
// is 0.5 m wide, or 15 % of the room's shorter side where that is less. A room that is no rectangle has those points of the rectangle
// about it that lie in the room. At least one point, in any room.
RoomGrid room_grid(const Building *building, const Region *region, Arena *arena);

#endif
