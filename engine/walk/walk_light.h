// walk_light.h - a baked building.
#ifndef WALK_LIGHT_H
#define WALK_LIGHT_H

#include "radiosity/shoot.h"

// What was baked, of the graph that is drawn.
typedef struct WalkLight {
    const Mesh *mesh;
    const RadSolution *solution;
    const float *door_open;  // [opening_count] as they stood
} WalkLight;

#endif
