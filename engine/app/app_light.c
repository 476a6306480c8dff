// app_light.c - finds and reads a .rad file for a building that is shown, or makes it.
#include "engine/app/app_light.h"

#include <unistd.h>

#include "engine/app/bake.h"
#include "maps/maps.h"
#include "radiosity/show/fine_mesh.h"

const char *app_light_place(const Building *building, Arena *arena) {
    return app_cache_path(arena, arena_format(arena, "%016llx.rad", (unsigned long long)building->hash));
}

int app_find_lights(const char *file, const char *map, const char *given, Arena *arena,
                    const char *out[APP_LIGHTS]) {
    int count = 0;
    Building building;
    Error error;
    out[0] = given;
    if (given) return 1;
    const char *slash = strrchr(file, '/'), *dot = strrchr(slash ? slash : file, '.');
    int length = (int)(dot ? dot - file : (long)strlen(file));
    out[0] = arena_format(arena, "%.*s.rad", length, file);
    count += access(out[0], F_OK) == 0;
    // A file that cannot be read is told of by those who load it.
    if (maps_read_map(file, map, arena, &building, &error)) {
        out[count] = app_light_place(&building, arena);
        count += out[count] && access(out[count], F_OK) == 0;
    }
    return count;
}

// The building as it is, lit.
static WalkLight shown_of(const FineMesh *fine, const RadSolution *solution, const float *doors,
                          Arena *arena) {
    RadSolution *shown = ARENA_ARRAY(arena, RadSolution, 1);
    *shown = fine_light(fine, solution, arena);
    return (WalkLight){&fine->mesh, shown, doors, fine};
}

bool app_load_light(const char *path, const AppScene *scene, Arena *arena, WalkLight *out, Error *error) {
    const CellGraph *graph = &scene->graph;
    MeshOptions options;
    Arena scratch = {0};
    float *doors = ARENA_ARRAY(arena, float, scene->building.opening_count + 1);
    Vec3 *vertices = ARENA_ARRAY(&scratch, Vec3, graph->vertex_count + 1);
    Mesh *mesh = ARENA_ARRAY(arena, Mesh, 1);
    RadSolution *solution = ARENA_ARRAY(arena, RadSolution, 1);
    bool good = rad_load_options(path, &scene->building, arena, &options, doors, error);
    if (good) {
        memcpy(vertices, graph->vertices, (size_t)graph->vertex_count * sizeof *vertices);
        vis_pose(graph, doors, vertices);
        options.proxies = proxies_find(graph, vertices, options.proxy, arena);
        good = mesh_build(graph, vertices, doors, &options, arena, mesh, error) &&
               rad_load(path, mesh, doors, arena, solution, error);
    }
    arena_free(&scratch);
    if (good) *out = shown_of(fine_mesh_new(mesh, arena), solution, doors, arena);
    return good;
}

AppBake *app_bake_new(const char *file, const AppScene *scene, Arena *arena) {
    AppBake *bake = ARENA_ARRAY(arena, AppBake, 1);
    Error error;
    *bake = (AppBake){.scene = scene, .file = file};
    if (!app_emits(scene) || !app_has_walls(scene, &error)) return NULL;
    bake->out = app_light_place(&scene->building, arena);
    if (!app_cache_takes(bake->out, APP_LIGHT_ROOM)) bake->out = NULL;
    return bake;
}

typedef struct Shower {
    const LightHooks *hooks;
    const FineMesh *fine;
} Shower;

static void show(void *context, const RadSolution *so_far) {
    const Shower *shower = context;
    Arena scratch = {0};
    WalkLight shown = shown_of(shower->fine, so_far, NULL, &scratch);
    shower->hooks->show(shower->hooks->context, shown.mesh, shown.solution);
    arena_free(&scratch);
}

bool app_bake(void *context, const LightHooks *hooks, Arena *arena, WalkLight *out, Error *error) {
    const AppBake *bake = context;
    BakeArguments a = bake_default_arguments();
    Mesh *mesh = ARENA_ARRAY(arena, Mesh, 1);
    RadSolution *solution = ARENA_ARRAY(arena, RadSolution, 1);
    Shower shower = {hooks, NULL};
    float *doors;
    a.file = bake->file;
    a.rad.threads = hooks->threads;
    if (!bake_mesh(&a, bake->scene, NULL, &hooks->progress, arena, &doors, mesh, error) ||
        !progress_report(&hooks->progress, "mesh", 0) || !rad_start(mesh, arena, solution, error))
        return false;
    shower.fine = fine_mesh_new(mesh, arena);
    rad_fit(mesh, &a.rad);
    if (hooks->show) {
        show(&shower, solution);
        a.rad.show = show;
        a.rad.show_context = &shower;
        a.rad.show_every = hooks->show_every;
    }
    RadReport report = rad_shoot(mesh, &bake->scene->forest, doors, &a.rad, &hooks->progress, solution);
    if (report.stopped) return error_set(error, "stopped");
    *error = (Error){""};
    if (bake->out) rad_save(bake->out, mesh, doors, solution, error);
    *out = shown_of(shower.fine, solution, doors, arena);
    return true;
}
