// sh3d_walls.h - walls as outlines, for the parts of the reader that lay things along them.
#ifndef MAPS_SH3D_WALLS_H
#define MAPS_SH3D_WALLS_H

#include "maps/sweethome/sh3d.h"

typedef struct Sh3dWall {
    const XmlNode *node;
    const char *id, *place;
    Vec2 start, end;  // of the axis
    double arc;       // angle swept from start to end, counter-clockwise; 0: straight
    double thickness;
    double floor, top[2];  // absolute heights: foot, top at start and end
    int storey;
    int joined[2];  // the walls it joins at start and end, -1: none
    int *left_material,
        *right_material;  // [side_count] of the chord from each point on; the last: of the wall's ends
    int top_material;
    Vec2 *left, *right;  // [side_count] from start to end; mitred at last
    int side_count;
    double beyond
        [2];  // metres by which the right and the left side lie beyond the thickness, see sh3d_widened_walls
    bool bounding;  // reaches the ceiling, or stands under a sloped one
} Sh3dWall;

// ---- sh3d_walls.c

// The walls as thick as they are with their baseboards, mitred: [wall_count], of as many points as s->walls.
Sh3dWall *sh3d_widened_walls(Sh3d *s);
// The element of the baseboard on a side; NULL: it has none.
const XmlNode *sh3d_board(const Sh3dWall *w, bool left);
// How pictures count along a side of a straight wall, and along chord i of an arc.
Sh3dFrame sh3d_side_frame(const Sh3dWall *w, bool left);
Sh3dFrame sh3d_chord_frame(const Sh3dWall *w, bool left, int i);

// ---- sh3d_baseboards.c

void sh3d_add_baseboards(Sh3d *s);  // into the building; call after the openings are read

#endif
