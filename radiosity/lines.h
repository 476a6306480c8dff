// lines.h - the straight lines that bound the faces of a mesh. Neighbours along an edge, and all faces that meet along one
// straight line, are cut by the very same line, so that between them no sample is lost or counted twice.
#ifndef RADIOSITY_LINES_H
#define RADIOSITY_LINES_H

#include "radiosity/mesh.h"

// How far the vertices of a straight line may lie off it, metres: above the rounding of readers' and clippers' arithmetic
// far from the origin, below all that could show.
#define RAD_STRAIGHT 1e-7

// An edge of a face, counter-clockwise from its front: a point of its line, and the direction along it, unit. Of the same line
// they are the same to the last bit, or `along` is the exact opposite.
typedef struct FaceEdge {
    Vec3 point, along;
    int line;
    int sign;  // 1: it goes along the line, -1: against it
} FaceEdge;

typedef struct FaceLines {
    FaceEdge *edges;
    int *first_edge;  // [face_count + 1] face f has edges[first_edge[f]] .. ; each line at most once
    int line_count, edge_count, face_count;
    int most_edges;  // of one face
} FaceLines;

FaceLines lines_of_mesh(const Mesh *mesh, Arena *arena);

#endif
