// bake.h - a bake from a building's file to a .rad file, a .glb file, or both.
#ifndef APP_BAKE_H
#define APP_BAKE_H

#include "engine/app/app.h"
#include "engine/app/bake_probes.h"
#include "engine/scene/bake_mesh.h"

typedef struct BakeArguments {
    SceneOptions load;
    BakeOptions bake;
    const char *file;
    // .rad and .glb, NULL: none; both NULL: a .rad into the cache
    const char *out, *model;
    bool final_gather, resume, json;
    // Of shooting; 0: no limit.
    double seconds;
    Probes probes;
    // The file that probes were read from, the last one; NULL: none.
    const char *probe_file;
} BakeArguments;
BakeArguments bake_default_arguments(void);

int bake(BakeArguments *arguments);  // the exit code

#endif
