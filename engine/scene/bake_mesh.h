// bake_mesh.h - the mesh that a bake of a scene begins with.
#ifndef SCENE_BAKE_MESH_H
#define SCENE_BAKE_MESH_H

#include "engine/scene/scene.h"
#include "radiosity/shoot/adapt.h"

// How a scene is baked.
typedef struct BakeOptions {
    // Element 0: as fits the building.
    MeshOptions mesh;
    AdaptOptions adapt;
    // Residual and resolution 0, row_bytes RAD_ROWS_FIT: as fit the mesh (rad_fit).
    RadOptions rad;
    // Where the doors stand (door_state.h); NULL: as drawn.
    const char *doors;
    // The scene's; all zeros: night.
    Daylight day;
    // The member that bakes a part of the building (mesh.part); NULL: the whole building is baked.
    TeamMember *member;
} BakeOptions;
BakeOptions bake_default_options(void);
// Memory that the light of the whole building takes at least, bytes.
size_t bake_least_bytes(const BakeOptions *options, const CellGraph *graph);

// The doors, [opening_count], and the mesh that a bake begins with, or goes on with from the .rad file `resumed` (NULL: from
// nothing). The scene was loaded with lamps. Refuses a scene without light, and too many elements; fails, "stopped", when progress
// stops it.
bool bake_mesh(const BakeOptions *options, const LoadedScene *scene, const char *resumed,
               const Progress *progress, Arena *arena, float **doors, Mesh *out, Error *error);

#endif
