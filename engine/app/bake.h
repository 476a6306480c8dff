// bake.h - a bake from a building's file to a .rad file, a .glb file, or both.
#ifndef APP_BAKE_H
#define APP_BAKE_H

#include "engine/app/app.h"
#include "engine/app/bake_probes.h"
#include "radiosity/shoot/adapt.h"

enum { BAKE_DOORS_DRAWN, BAKE_DOORS_OPEN, BAKE_DOORS_CLOSED, BAKE_DOORS };
extern const char *const BAKE_DOORS_NAMES[BAKE_DOORS];

typedef struct BakeArguments {
    AppOptions load;
    MeshOptions mesh;  // element 0: what fits the building
    AdaptOptions adapt;
    RadOptions rad;
    const char *file;
    const char *out, *model;  // .rad and .glb, NULL: none; both NULL: a .rad into the cache
    int doors;                // one of the above
    double sky[3];            // radiance, W/m^2/sr a channel; 0: night
    bool final_gather, resume, json;
    Probes probes;
    const char *probe_file;  // that they were read from, the last one; NULL: none
} BakeArguments;
BakeArguments bake_default_arguments(void);

// How far each door is open in one of these states, [opening_count]; and the graph's vertices with the doors there.
float *bake_doors(const Building *building, int state, Arena *arena);
Vec3 *bake_vertices(const CellGraph *graph, const float *doors, Arena *arena);
// The doors, [opening_count], and the mesh that a bake of these begins with, or goes on with from the .rad file `resumed` (NULL: from
// nothing). Refuses what would be too many elements; fails, "stopped", when progress stops it.
bool bake_mesh(const BakeArguments *arguments, const AppScene *scene, const char *resumed,
               const Progress *progress, Arena *arena, float **doors, Mesh *out, Error *error);

int bake(BakeArguments *arguments);  // the exit code

#endif
