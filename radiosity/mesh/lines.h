// lines.h - the straight lines that bound the faces of a mesh. Neighbours along an edge, and all faces that meet along one
// straight line, are cut by the very same line, so that between them no sample is lost or counted twice.
#ifndef RADIOSITY_LINES_H
#define RADIOSITY_LINES_H

#include "radiosity/mesh/mesh.h"

// How far the vertices of a straight line may lie off it, metres: above the rounding of readers' and clippers' arithmetic
// far from the origin, below any visible distance.
#define RAD_STRAIGHT 1e-7

// An edge of a face, counter-clockwise from its front, by two vertices of its line. Of the same line they are the same two,
// one way round or the other. At least 0: the vertex is the face's own, so many along its outline; else it is
// Mesh.vertices[~from].
typedef struct FaceEdge {
    int from, to;
} FaceEdge;

typedef struct FaceLines {
    FaceEdge *edges;
    int *first_edge;  // [face_count + 1] face f has edges[first_edge[f]] .. ; each line at most once
    int line_count, edge_count, face_count;
    int most_edges;  // of one face
} FaceLines;

FaceLines lines_of_mesh(const Mesh *mesh, Arena *arena);

#endif
