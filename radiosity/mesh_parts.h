// mesh_parts.h - what the files of the mesh share.
#ifndef RADIOSITY_MESH_PARTS_H
#define RADIOSITY_MESH_PARTS_H

#include "radiosity/mesh.h"
#include "radiosity/mesh_places.h"

typedef struct MeshBuilder {
    Mesh *mesh;
    Arena *arena, scratch;
    Places places;
    int element_capacity, patch_capacity, corner_capacity, square_capacity;
} MeshBuilder;

// mesh_squares.c: the grid of a face with these corners, places of the builder.
void mesh_lay_grid(MeshBuilder *builder, Face *face, const int *corner, int count);
// Its elements and patches; all faces' outlines are places by then.
void mesh_cut_face(MeshBuilder *builder, int face);

#endif
