// sh3d_pieces.h - pieces of furniture, and the leaves that the models of doors draw. Only sh3d_pieces.c and sh3d_leaves.c use it.
#ifndef MAPS_SH3D_PIECES_H
#define MAPS_SH3D_PIECES_H

#include "maps/sweethome/sh3d.h"

// A piece of furniture as its file states it.
typedef struct Piece {
    const XmlNode *node;
    const char *name;
    Vec2 at;
    double z;  // of its foot
    double width, depth, height;
    double angle;
    double pitch, roll;
    bool mirrored;
    bool both_sides;  // its back faces are shown, too
    double turn[9];   // modelRotation, row by row
    bool coloured;
    unsigned colour;
} Piece;

enum { FRAME = -1 };

typedef struct Leaves {
    int *part;                        // [face_count] the leaf that each face moves with, or FRAME
    double drawn[SKETCH_MAX_LEAVES];  // how far each is open as the model is drawn, see Leaf
} Leaves;

// sh3d_leaves.c: fills the leaves of `o`, and how far it is open. `placed` [vertex_count] are the vertices of the model in the building.
Leaves sh3d_find_leaves(Sh3d *s, const Piece *p, const ObjModel *m, const Vec3 *placed, SketchOpening *o);
// The vertices with this leaf closed: the same array unless it is drawn open.
const Vec3 *sh3d_close_leaf(Sh3d *s, const ObjModel *m, const Vec3 *placed, const Leaves *leaves, int leaf,
                            const SketchOpening *o);

#endif
