// bake_mesh.c - doors, stand-ins, elements: from a scene to the mesh that is baked.
#include "engine/scene/bake_mesh.h"

#include <string.h>

#include "engine/core/memory.h"
#include "engine/scene/door_state.h"

// Options that lead to more elements than this are surely a mistake.
static const double MOST_ELEMENTS = 30e6;
// Less than any element takes with its light, bytes: 1,000 of small elements, else 1,300 to 3,700.
static const double LEAST_BYTES = 800;

BakeOptions bake_default_options(void) {
    BakeOptions o = {
        .mesh = mesh_default_options(), .adapt = adapt_default_options(), .rad = rad_default_options()};
    o.mesh.element = 0;
    o.rad.residual = 0;
    o.rad.form_factor.resolution = 0;
    o.rad.row_bytes = RAD_ROWS_FIT;
    return o;
}

static double count_elements(const CellGraph *graph, double side, double *area) {
    *area = 0;
    for (int i = 0; i < graph->polygon_count; i++) {
        const Polygon *p = &graph->polygons[i];
        *area += polygon_area(graph->vertices + p->first_vertex, p->vertex_count);
    }
    return *area / side / side + graph->polygon_count;
}

size_t bake_least_bytes(const BakeOptions *bake, const CellGraph *graph) {
    double side = bake->mesh.element, area;
    return (size_t)(LEAST_BYTES *
                    count_elements(graph, side > 0 ? side : mesh_fitting_element(graph), &area));
}

// The memory is that of the whole building: a bake in parts has only some of it at once.
static bool check_size(const char *file, double side, const CellGraph *graph, bool in_parts, Error *error) {
    double area, elements = count_elements(graph, side, &area);
    if (elements > MOST_ELEMENTS)
        return error_set(
            error, "%s: %.0f m^2 in elements of %g m are about %.2g elements (at most %g): give --element",
            file, area, side, area / side / side, MOST_ELEMENTS);
    if (in_parts || memory_fits((size_t)(LEAST_BYTES * elements))) return true;
    return error_set(
        error,
        "%s: its light, about %.2g elements, takes more memory than there is for it, at least %.0f MB "
        "(--memory MB allows more, --element M of larger elements takes less, `enfilade bake` stores it in "
        "parts)",
        file, elements, LEAST_BYTES * elements / (1 << 20));
}

// The file of a light that is resumed has the splits: light there asks for them no more, and a part that does not fit is told by name.
static bool find_mesh(const BakeOptions *bake, const AdaptScene *lit, MeshOptions *options,
                      const char *resumed, const Progress *progress, Arena *arena, Mesh *out, Error *error) {
    if (resumed) {
        const Building *building = lit->graph->building;
        float *doors = ARENA_ARRAY(arena, float, building->opening_count + 1);
        MeshOptions stored;
        if (!rad_load_options(resumed, building, arena, &stored, doors, error)) return false;
        options->splits = stored.splits;
    } else if (bake->adapt.share > 0) {
        AdaptOptions adapt = bake->adapt;
        adapt.day = bake->day;
        return adapt_mesh(lit, options, &adapt, &bake->rad, progress, arena, out, error);
    }
    return mesh_build(lit->graph, lit->door_open, options, arena, out, error);
}

// Before stand-ins and meshes are made, which takes long in furnished homes; many have no lamps.
static bool check_light(const BakeOptions *bake, const LoadedScene *scene, Error *error) {
    if (daylight_shines(&bake->day) || scene_emits(scene)) return true;
    return error_set(error,
                     "%s: nothing emits light: it has no lamps, and none of its %d materials an emission "
                     "(--fill-lamps on lights its rooms, --day brings daylight)",
                     scene->building.source, scene->building.material_count);
}

bool bake_mesh(const BakeOptions *bake, const LoadedScene *scene, const char *resumed,
               const Progress *progress, Arena *arena, float **doors, Mesh *out, Error *error) {
    const CellGraph *graph = &scene->graph;
    MeshOptions options = bake->mesh;
    if (!scene_has_walls(scene, error) || !check_light(bake, scene, error)) return false;
    options.threads = bake->rad.threads;
    if (options.element == 0) options.element = mesh_fitting_element(graph);
    if (!check_size(scene->building.source, options.element, graph, bake->member != NULL, error))
        return false;
    *doors = door_state_drawn(&scene->building, arena);
    if (bake->doors && !door_state_apply(&scene->building, bake->doors, *doors, error)) return false;
    AdaptScene lit = {graph, &scene->forest, *doors, bake->member};
    if (!options.proxies) options.proxies = proxies_find(graph, options.proxy, arena);
    return find_mesh(bake, &lit, &options, resumed, progress, arena, out, error);
}
