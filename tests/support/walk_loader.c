// walk_loader.c - see the header.
#include "tests/support/walk_loader.h"

#include "engine/scene/light.h"

bool walk_loader_lit(void *context, const char *path, Arena *arena, WalkScene *out, Error *error) {
    (void)context;
    SceneOptions load = scene_default_options();
    load.lamps = SCENE_LAMPS_ALL;
    return walk_scene_load(&load, path, arena, out, error);
}
