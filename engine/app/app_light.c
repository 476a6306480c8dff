// app_light.c - finds and reads a .rad file for a building that is shown.
#include "engine/app/app_light.h"

#include <unistd.h>

const char *app_find_light(const char *file, const char *given, Arena *arena) {
    if (given) return given;
    const char *slash = strrchr(file, '/'), *dot = strrchr(slash ? slash : file, '.');
    int length = (int)(dot ? dot - file : (long)strlen(file));
    const char *beside = arena_format(arena, "%.*s.rad", length, file);
    return access(beside, F_OK) == 0 ? beside : NULL;
}

bool app_load_light(const char *path, const AppScene *scene, Arena *arena, WalkLight *out, Error *error) {
    const CellGraph *graph = &scene->graph;
    MeshOptions options;
    Arena scratch = {0};
    float *doors = ARENA_ARRAY(arena, float, scene->building.opening_count + 1);
    Vec3 *vertices = ARENA_ARRAY(&scratch, Vec3, graph->vertex_count + 1);
    Mesh *mesh = ARENA_ARRAY(arena, Mesh, 1);
    RadSolution *solution = ARENA_ARRAY(arena, RadSolution, 1);
    bool good = rad_load_options(path, &scene->building, &options, doors, error);
    if (good) {
        memcpy(vertices, graph->vertices, (size_t)graph->vertex_count * sizeof *vertices);
        vis_pose(graph, doors, vertices);
        good = mesh_build(graph, vertices, doors, &options, arena, mesh, error) &&
               rad_load(path, mesh, doors, arena, solution, error);
    }
    arena_free(&scratch);
    *out = (WalkLight){mesh, solution};
    return good;
}
