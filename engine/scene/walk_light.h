// walk_light.h - a baked building, as it is shown.
#ifndef SCENE_WALK_LIGHT_H
#define SCENE_WALK_LIGHT_H

#include "radiosity/show/fine_mesh.h"

// Light on the graph that is drawn.
typedef struct WalkLight {
    const Mesh *mesh;
    const RadSolution *solution;
    // [opening_count] share by which each door was open
    const float *door_open;
    // How `mesh` has its light from the mesh that was baked; NULL: it is that one.
    const FineMesh *fine;
} WalkLight;

#endif
