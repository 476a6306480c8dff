// mesh_cutting.h - a face on its way into elements.
#ifndef RADIOSITY_MESH_CUTTING_H
#define RADIOSITY_MESH_CUTTING_H

#include "radiosity/mesh_parts.h"

enum { MESH_SEVERAL = -2 };

typedef struct MeshCutting {
    MeshBuilder *builder;
    const Face *face;
    const Vec3 *outline;  // [count] from the face's origin
    int count;
    Vec3 *part, *spare;  // [count + 8] of the part looked at
    MeshLeaf *leaves;    // [leaf_count]
    int leaf_count;
    int *owner;     // [nx * ny] the leaf whose block a square is in
    int *element;   // [leaf_count] of each leaf, -1: none, MESH_SEVERAL: it is in pieces
    double square;  // area of a whole one, m^2
} MeshCutting;

// mesh_squares.c: what a block holds of the face, in `part` from the face's origin; returns how many corners it has.
int mesh_part_in(MeshCutting *cutting, MeshBlock block);
// mesh_patches.c: the elements and patches that the leaves become.
void mesh_add_patches(MeshCutting *cutting, Face *face, int index);

#endif
