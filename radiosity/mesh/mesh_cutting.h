// mesh_cutting.h - a face on its way into elements.
#ifndef RADIOSITY_MESH_CUTTING_H
#define RADIOSITY_MESH_CUTTING_H

#include "radiosity/mesh/mesh_parts.h"

enum { MESH_SEVERAL = -2 };

typedef struct MeshCutting {
    MeshBuilder *builder;
    Arena *arena;  // of the thread that cuts it
    int index;
    const Face *face;
    bool is_cut;          // something stands on it
    const Vec3 *outline;  // [count] from the face's origin
    int count;
    Vec3 *part, *spare;  // [count + 8] of the part looked at
    MeshLeaf *leaves;    // [leaf_count]
    int leaf_count;
    int *owner;     // [nx * ny] the leaf whose block a square is in
    int *element;   // [leaf_count] of each leaf, -1: none, MESH_SEVERAL: it is in pieces,
    int *code;      // [leaf_count] and what Mesh.squares says of those then
    int merged;     // slivers that became part of their neighbours
    double square;  // area of a whole one, m^2
    // The pieces into which leaves are cut: leaf k has pieces[first_piece[k]] .. ; one where nothing stands on the face.
    MeshPiece *pieces;
    int *first_piece, piece_count, piece_capacity;  // [leaf_count + 1]
} MeshCutting;

// mesh_patches.c: the elements and patches that the leaves become: numbers follow each other from face to face.
void mesh_add_patches(MeshCutting *cutting);
// mesh_owners.c: which element each square of a face is in, once its elements have numbers; memory of the arena.
void mesh_give_squares(const MeshCutting *cutting, Arena *arena);

#endif
