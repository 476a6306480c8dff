// bake.h - a bake from a building's file to a .rad file, a .glb file, or both.
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
    const char *file;
    const char *out, *model;  // .rad and .glb, NULL: none; both NULL: a .rad into the cache
    int doors;                // one of the above
    bool final_gather, resume, json;
    Probes probes;
} BakeArguments;
BakeArguments bake_default_arguments(void);

int bake(BakeArguments *arguments);  // the exit code

#endif
