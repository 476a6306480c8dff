// nodes.h - where the light of a mesh is told between elements: at each vertex once for all elements that meet there smoothly.
#ifndef RADIOSITY_NODES_H
#define RADIOSITY_NODES_H

#include "radiosity/mesh/mesh.h"

// Elements that share an edge are smooth neighbours where they are of one material, nothing stands on the edge, and they lie in
// one plane or are facets of one curved thing. Those of a vertex that are neighbours, or neighbours of neighbours there, have
// one node: both ends of a smooth edge look the same from both sides, and each side of a crease has nodes of its own.
// Read only once they are made: any number of threads. They live in the arena of the call that made them.
typedef struct Nodes {
    int count;
    int *of_corner;  // [mesh->corner_count]
    int *vertex;     // [count] in Mesh.vertices
    Vec3 *normal;    // [count] unit, the mean of its elements
    int *first;      // [count + 1] in `element`
    int *element;    // of nodes: those that meet there, increasing
} Nodes;

// All nodes of a mesh, by vertex.
Nodes nodes_of(const Mesh *mesh, Arena *arena);

// Facets whose normals lean from each other by less belong to one curved surface: the cosine of 31 degrees. Models cut a circle
// into 12 parts or more; a chamfer leans by 45 degrees, and faces that lean more are lit too differently to share a mean.
#define NODES_CURVED 0.857

#endif
