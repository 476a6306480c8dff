// bake.h - a bake from a building's file to a .rad file.
#ifndef APP_BAKE_H
#define APP_BAKE_H

#include "engine/app/app.h"
#include "engine/app/bake_probes.h"

enum { BAKE_DOORS_DRAWN, BAKE_DOORS_OPEN, BAKE_DOORS_CLOSED, BAKE_DOORS };
extern const char *const BAKE_DOORS_NAMES[BAKE_DOORS];

typedef struct BakeArguments {
    AppOptions load;
    MeshOptions mesh;
    RadOptions rad;
    const char *file, *out;  // out NULL: into the cache
    int doors;               // one of the above
    bool resume, json;
    Probes probes;
} BakeArguments;
BakeArguments bake_default_arguments(void);

// The doors, [opening_count], and the mesh that a bake of these begins with. Refuses what would be too many elements.
bool bake_mesh(const BakeArguments *arguments, const AppScene *scene, Arena *arena, float **doors, Mesh *out,
               Error *error);

int bake(BakeArguments *arguments);  // the exit code

#endif
