// walk_light.h - a baked building ready for the screen: every element's light, smooth from corner to corner.
#ifndef WALK_LIGHT_H
#define WALK_LIGHT_H

#include "radiosity/shoot.h"

// What was baked, of the graph that is drawn.
typedef struct WalkLight {
    const Mesh *mesh;
    const RadSolution *solution;
} WalkLight;

// Radiosities, W/m^2, at the corners of elements: the mean of the elements around a place that lie in one plane and are of
// one material, [corner_count] as Mesh.corners; and of whole faces, [face_count].
typedef struct VertexLight {
    double (*corner)[3], (*face)[3];
} VertexLight;
VertexLight walk_light_vertices(const Mesh *mesh, const RadSolution *solution, Arena *arena);

#endif
