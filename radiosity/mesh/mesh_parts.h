// mesh_parts.h - the parts that the files of the mesh share.
#ifndef RADIOSITY_MESH_PARTS_H
#define RADIOSITY_MESH_PARTS_H

#include "radiosity/mesh/mesh.h"
#include "radiosity/mesh/mesh_places.h"

// A line that elements of a face are cut along, from the face's origin.
typedef struct MeshCut {
    Vec3 from, to;
    Vec3 open;  // in the plane, away from the object that stands there; 0: not known
} MeshCut;

typedef struct MeshBuilder {
    Mesh *mesh;
    Arena *arena, scratch;
    Places places;
    Arena cut_arena;
    MeshCut *cuts;  // of face f first_cut[f] .. first_cut[f + 1] - 1
    int *first_cut, cut_count, cut_capacity, shared_capacity;
    int element_capacity, patch_capacity, corner_capacity;
    int laid, cut;  // bits of the splits read so far, by those who lay grids and by those who cut along them
} MeshBuilder;

// mesh_squares.c: the grid of a face with these corners, places of the builder.
void mesh_lay_grid(MeshBuilder *builder, Face *face, const int *corner, int count);
// mesh_places.c: outlines of faces from their corners, places of the builder; and of all elements, once they are cut.
void mesh_anchor_outlines(MeshBuilder *builder, int *corner);
void mesh_anchor_elements(MeshBuilder *builder);
// mesh_contacts.c: the cuts of all faces, whose outlines are places by then. False where there are too many to look for.
bool mesh_find_cuts(MeshBuilder *builder);

// mesh_squares.c: how far inside a convex polygon about the normal n a point of its plane is, metres; below 0: outside.
double mesh_inside(const Vec3 *v, int count, Vec3 n, Vec3 point);

// mesh_squares.c: the elements and patches of all faces, whose outlines are places by then. False where squares would be too many.
bool mesh_cut_faces(MeshBuilder *builder);

#endif
