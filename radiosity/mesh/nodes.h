// nodes.h - the points between which light is interpolated: at each vertex, one node for all elements that meet there smoothly.
#ifndef RADIOSITY_NODES_H
#define RADIOSITY_NODES_H

#include "radiosity/mesh/mesh.h"

// Elements that share an edge are smooth neighbours where they are of one material, nothing stands on the edge, and they lie in
// one plane or are facets of one curved object. At a vertex, elements that are linked by smooth neighbours share one node. The two
// sides of a smooth edge therefore have equal light at its ends, and each side of a crease has nodes of its own.
// Any number of threads may read the nodes once they are made. They live in the arena of the call that made them.
typedef struct Nodes {
    int count;
    int *of_corner;  // [mesh->corner_count] the node of each corner in Mesh.corners
    int *vertex;     // [count] in Mesh.vertices
    Vec3 *normal;    // [count] unit, the mean of its elements
    int *first;      // [count + 1] in `element`
    int *element;    // [mesh->corner_count] the elements that meet at each node, increasing
} Nodes;

// All nodes of a mesh, numbered in the order of the corners.
Nodes nodes_of(const Mesh *mesh, Arena *arena);

// Turns the normals of nodes on leaves, when the mesh was posed anew (mesh_pose).
void nodes_pose(Nodes *nodes, const Mesh *mesh);

// Facets belong to one curved surface if the cosine of the angle between their normals is above this: 31 degrees. Models cut a
// circle into 12 parts or more; a chamfer turns by 45 degrees, and faces that turn more are lit too differently to share a mean.
#define NODES_CURVED 0.857

#endif
