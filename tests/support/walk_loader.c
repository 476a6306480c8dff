// walk_loader.c - see the header.
#include "tests/support/walk_loader.h"

#include "engine/app/app_light.h"

bool walk_loader_lit(void *context, const char *path, Arena *arena, WalkScene *out, Error *error) {
    (void)context;
    AppScene *scene = ARENA_ARRAY(arena, AppScene, 1);
    AppOptions options = app_default_options();
    options.lamps = true;
    if (!app_load(path, &options, arena, scene, error)) return false;
    AppBake *bake = app_bake_new(path, scene, arena);
    *out = (WalkScene){.graph = &scene->graph,
                       .forest = &scene->forest,
                       .baker = {bake ? app_bake : NULL, bake, bake && bake->out}};
    return true;
}
