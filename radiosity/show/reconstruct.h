// reconstruct.h - radiosities at vertices from those of elements, and between them: the light that is shown.
#ifndef RADIOSITY_RECONSTRUCT_H
#define RADIOSITY_RECONSTRUCT_H

#include "radiosity/mesh/nodes.h"
#include "radiosity/shoot/shoot.h"

// Light at the corners of elements, W/m^2 a channel. Read only once it is made: any number of threads; it lives in the arena of the call.
typedef struct VertexLight {
    double (*corner)[3];  // [mesh->corner_count] as Mesh.corners; equal for all corners of a node
    double (*face)[3];    // [mesh->face_count] mean by area
    int *
        triangle;  // [3 * mesh->corner_count] of an element from 3 * first_corner on; NULL: cut anew whenever asked
} VertexLight;

// A solution that was gathered at nodes is taken as it is there.
VertexLight reconstruct_light(const Mesh *mesh, const RadSolution *solution, Arena *arena);

// [nodes->count]
void reconstruct_nodes(const Mesh *mesh, const Nodes *nodes, const RadSolution *solution, double (*out)[3]);

// The triangles that elements are drawn as, for a VertexLight that is asked often.
int *reconstruct_triangles(const Mesh *mesh, Arena *arena);

// At a point of a face: linear over the triangles that elements are drawn as (polygon_triangulate). A point that is a rounding
// outside counts as the nearest of its element.
void reconstruct_at(const Mesh *mesh, const VertexLight *light, int face, Vec3 point, double out[3]);
// The same where the element is known.
void reconstruct_in(const Mesh *mesh, const VertexLight *light, int element, Vec3 point, double out[3]);

// The share of an element's area.
Vec3 element_centroid(const Mesh *mesh, int element);

#endif
