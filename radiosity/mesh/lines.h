// lines.h - the straight lines that bound the faces of a mesh. Neighbours along an edge, and all faces that meet along one
// straight line, are bounded by the very same line, so that no sample between them is lost or counted twice.
#ifndef RADIOSITY_LINES_H
#define RADIOSITY_LINES_H

#include "radiosity/mesh/mesh.h"

// How far the vertices of a straight line may lie off it, metres: above the rounding of readers' and clippers' arithmetic
// far from the origin, below any visible distance.
#define RAD_STRAIGHT 1e-7

// An edge of a face, counter-clockwise seen from the face's front, by two vertices of the edge's line. All edges on a line name the
// same two vertices, in either order. A number >= 0 is the position of the vertex in the face's outline; a number n < 0 means
// Mesh.vertices[~n].
typedef struct FaceEdge {
    int from, to;
} FaceEdge;

typedef struct FaceLines {
    FaceEdge *edges;
    // [face_count + 1] face f has edges[first_edge[f]] .. edges[first_edge[f + 1] - 1], each line at most once
    int *first_edge;
    int line_count, edge_count, face_count;
    int most_edges;  // the largest number of edges of a face
    // [element_count + 1] of elements that share a square of their face: element e has borders[first_border[e]] .. borders[first_border[e +
    // 1] - 1]. Others have none.
    int *first_border;
    struct ElementBorder *borders;
} FaceLines;

// A side of an element, in squares of the face's grid: a point (column, row) is inside where x * column + y * row >= at.
typedef struct ElementBorder {
    double x, y, at;
} ElementBorder;

FaceLines lines_of_mesh(const Mesh *mesh, Arena *arena);

// mesh_element_at, with borders that are known: another answer is possible within a rounding of a border alone.
int lines_element_at(const FaceLines *lines, const Mesh *mesh, int face, Vec3 point);

#endif
