// app_light.c - finds and reads a .rad file for a building that is shown.
#include "engine/app/app_light.h"

#include <unistd.h>

#include "engine/core/file.h"
#include "maps/maps.h"

bool app_light_place(const Building *building, Arena *arena, const char **out, Error *error) {
    char *folder;
    if (!file_cache_folder(arena, &folder, error)) return false;
    *out = arena_format(arena, "%s/%016llx.rad", folder, (unsigned long long)building->hash);
    return true;
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
    if (maps_read_map(file, map, arena, &building, &error) &&
        app_light_place(&building, arena, &out[count], &error))
        count += access(out[count], F_OK) == 0;
    return count;
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
        good = mesh_build(graph, vertices, doors, &options, arena, mesh, error) &&
               rad_load(path, mesh, doors, arena, solution, error);
    }
    arena_free(&scratch);
    *out = (WalkLight){mesh, solution};
    return good;
}
