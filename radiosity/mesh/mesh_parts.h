// mesh_parts.h - the types and functions that the mesh's source files share.
#ifndef RADIOSITY_MESH_PARTS_H
#define RADIOSITY_MESH_PARTS_H

#include "radiosity/mesh/mesh.h"
#include "radiosity/mesh/mesh_places.h"

// A line along which elements of a face are cut.
typedef struct MeshCut {
    Vec3 from, to;  // metres from the face's origin
    Vec3 open;      // in the plane, away from the object that stands there; 0: not known
} MeshCut;

typedef struct MeshBuilder {
    Mesh *mesh;
    Arena *arena, scratch;
    Places places;
    Arena cut_arena;
    MeshCut *cuts;  // face f has cuts[first_cut[f]] .. cuts[first_cut[f + 1] - 1]
    int *first_cut, cut_count, cut_capacity, shared_capacity;
    int element_capacity, patch_capacity, corner_capacity;
    int laid, cut;  // bits of the splits read so far: in laying grids, and in cutting faces along them
} MeshBuilder;

// mesh_squares.c: lays the grid of a face. `corner` [count] are its corners, indices of the builder's places.
void mesh_lay_grid(MeshBuilder *builder, Face *face, const int *corner, int count);
// mesh_places.c: makes the outlines of all faces from their corners (indices of the builder's places): each place that lies on an
// edge becomes a corner. mesh_anchor_elements does the same for the elements, once they are cut.
void mesh_anchor_outlines(MeshBuilder *builder, int *corner);
void mesh_anchor_elements(MeshBuilder *builder);
// mesh_contacts.c: finds the cuts of all faces, after mesh_anchor_outlines. False where there are too many faces to search.
bool mesh_find_cuts(MeshBuilder *builder);

// mesh_centres.c: moves centres of patches out of things that stand on the patches, once the elements are made.
void mesh_free_centres(Mesh *mesh);
// mesh_cells.c: finds the cells of all patches.
void mesh_find_cells(Mesh *mesh);
// The same of one that belongs to no cell's own surfaces, -1: it is inside a wall. `hint` as for vis_locate. Where the
// centre is inside a wall another point becomes the centre.
int mesh_find_cell(Mesh *mesh, int patch, int hint);
// mesh_pose.c: notes what moves, once all but the cells of patches is made.
void mesh_find_moving(Mesh *mesh, Arena *arena);

// mesh_squares.c: how far a point of the plane lies inside a convex polygon about the normal n, metres; below 0: outside.
double mesh_inside(const Vec3 *v, int count, Vec3 n, Vec3 point);

// mesh_squares.c: makes the elements and patches of all faces, after mesh_anchor_outlines. False where there would be too many
// squares.
bool mesh_cut_faces(MeshBuilder *builder);

#endif
