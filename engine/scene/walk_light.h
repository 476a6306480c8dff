// walk_light.h - a baked building, as it is shown.
#ifndef SCENE_WALK_LIGHT_H
#define SCENE_WALK_LIGHT_H

#include "radiosity/mesh/lamps.h"
#include "radiosity/show/fine_mesh.h"

// The light of each source by itself, and the meshes that lead to the one that is drawn.
typedef struct LightStates {
    const Lamps *lamps;
    const Mesh *found, *shown;    // light was found on the one, and is shown on the other
    const RadSolution *solution;  // on `found`, with `each`
} LightStates;

// Light on the graph that is drawn.
typedef struct WalkLight {
    const Mesh *mesh;
    const RadSolution *solution;
    // [opening_count] share by which each door was open
    const float *door_open;
    // How `mesh` has its light from the mesh that was baked; NULL: it is that one.
    const FineMesh *fine;
    // NULL: the light of each lamp is not known.
    const LightStates *states;
    // Finds the light where doors stand elsewhere (light_follow); NULL: nobody does.
    struct LightFollower *follower;
} WalkLight;

#endif
