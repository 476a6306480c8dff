// panes.h - panes of glass in windows and glazed doors, and the share of light that passes them; black panes that close rooms.
#ifndef RADIOSITY_PANES_H
#define RADIOSITY_PANES_H

#include "visibility/vis.h"

// A pane of glass: an upright rectangle in the middle of a wall. A black one lies in the surface of its room, upright or level.
typedef struct Pane {
    Plane plane;
    Vec3 origin, x,
        y;  // a point p of the plane is on the pane where dot(x, p - origin) and dot(y, p - origin) are in 0 .. 1
    int opening;                 // in Building.openings
    int first_cell, cell_count;  // in Panes.cells: the cells that the pane stands in; none: not known
    int room;  // of a black pane, which lets nothing through: the region that it closes; -1: of glass
} Pane;

// Panes of a building whose doors stand in one way. Read only once made; lives in the arena of panes_of.
typedef struct Panes {
    Pane *panes;  // [count]
    int *cells;   // of the graph
    int count;
    const struct PaneRoom
        *rooms;  // [cell_count of the graph] with black panes: what they part; NULL: all are of glass
} Panes;

// Where a cell lies when the rooms are closed.
typedef struct PaneRoom {
    int room;   // a region of kind room, or one of the two below
    bool open;  // the room has an opening to the outdoors
} PaneRoom;
enum {
    PANES_OUTDOORS = -1,  // outdoors, or in an opening that leads there
    PANES_BETWEEN = -2,   // in a doorway, window or shaft between two rooms: parted from both
};

// One pane for each opening that is glazed: a window, or a door that is closed. A door that is open at all has none, nor has an opening
// whose door fills it (the lifts of Doom maps are called glazed because they never block sight). `door_open` as for vis_query.
Panes panes_of(const CellGraph *graph, const float *door_open, Arena *arena);
// Those of `all`, which are of closed doors, where doors stand as `door_open` says, into out->panes, with room for all.
void panes_pose(const Panes *all, const Building *building, const float *door_open, Panes *out);

// Those of `glass`, and a black pane for each portal through which a room sees another room, or a doorway, window or shaft between the two:
// what passes none of the black ones is light of the room alone, or of the outdoors. A level one is the rectangle about its portal, for in
// its plane there is nothing else but floor or ceiling.
Panes panes_between_rooms(const CellGraph *graph, const Panes *glass, Arena *arena);

// The panes that light to points before a surface in a cell may pass: those that the cell may see (-1: any) and that reach before the
// surface's plane. Into `out`, with room for all of `from`, which outlives it. Of the black ones a room meets its own first.
void panes_seen(const Panes *from, const StabForest *forest, int cell, Plane plane, Panes *out);

// The corners of a pane, counter-clockwise from the front of its plane.
void pane_corners(const Pane *pane, Vec3 out[4]);

// The z of the steepest unit vector from a point to a pane, a bound from above; -1: there are no panes.
double panes_highest(const Panes *panes, Vec3 from);

// The share of unpolarised light that passes one pane of clear float glass, 3 mm thick, at the angle to its normal with this cosine,
// 0 .. 1: 0.91 straight on, 0.83 at 60 degrees, 0 along the pane. All reflections between the two faces are summed, for each
// polarisation; light that the pane reflects or absorbs is lost (J. A. Duffie & W. A. Beckman, Solar Engineering of Thermal Processes,
// 4th edition 2013, equations 5.1.1 to 5.3.1).
double glass_transmits(double cosine);
// The same of any pane.
static inline double pane_transmits(const Pane *pane, double cosine) {
    return pane->room >= 0 ? 0 : glass_transmits(cosine);
}

// The share of light from one point to another that passes the panes between them: the product over all that the line crosses. A point in
// the plane of a pane counts as behind it. 1 where there are none.
double panes_transmit(const Panes *panes, Vec3 from, Vec3 to);
// The same of light that is known to get from a point in one cell to a point in another (-1: not known), perhaps not along this very line:
// with black panes nothing gets from a room to another one.
double panes_transmit_between(const Panes *panes, Vec3 from, int from_cell, Vec3 to, int to_cell);
// The same of light from infinitely far away, which arrives at the point `to` from the direction of the unit vector `source`.
double panes_transmit_from_afar(const Panes *panes, Vec3 to, Vec3 source);

#endif
