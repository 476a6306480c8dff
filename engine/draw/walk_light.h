// walk_light.h - a baked building.
#ifndef WALK_LIGHT_H
#define WALK_LIGHT_H

#include "radiosity/show/fine_mesh.h"

// What was baked, of the graph that is drawn.
typedef struct WalkLight {
    const Mesh *mesh;
    const RadSolution *solution;
    const float *door_open;  // [opening_count] as they stood
    const FineMesh *fine;    // how `mesh` has its light from the mesh that was baked; NULL: it is that one
} WalkLight;

#endif
