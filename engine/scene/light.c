// light.c - finds and reads a .rad file for a scene, or makes it.
#include "engine/scene/light.h"

#include <string.h>

#include "engine/core/clock.h"
#include "engine/scene/bake_mesh.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/direct.h"
#include "radiosity/show/shown.h"

const char *light_place(const Building *building, Arena *arena) {
    return scene_cache_path(arena, arena_format(arena, "%016llx.rad", (unsigned long long)building->hash));
}

// The building as it is, lit.
static WalkLight show_fine(const FineMesh *fine, const RadSolution *solution, const float *doors,
                           Arena *arena) {
    RadSolution *shown = ARENA_ARRAY(arena, RadSolution, 1);
    *shown = fine_light(fine, solution, arena);
    return (WalkLight){&fine->mesh, shown, doors, fine};
}

// The same on the mesh that shows the light.
static bool show_finer(const Mesh *mesh, const RadSolution *solution, const float *doors, Arena *arena,
                       WalkLight *out, Error *error) {
    const Mesh *shown;
    const RadSolution *light;
    if (!shown_light(mesh, solution, doors, arena, &shown, &light, error)) return false;
    *out = show_fine(fine_mesh_new(shown, arena), light, doors, arena);
    return true;
}

bool light_check_day(const char *file, const RadSolution *solution, const Daylight *day, Error *error) {
    const Daylight *had = &solution->day;
    char made[128], asked[128];
    bool both_dark = !daylight_shines(had) && !daylight_shines(day);
    if (both_dark || memcmp(had, day, sizeof *had) == 0) return true;
    day_describe(had, made, sizeof made);
    day_describe(day, asked, sizeof asked);
    return error_set(error, "%s: was made under %s (asked for: %s)", file, made, asked);
}

bool light_load(const char *path, const LoadedScene *scene, Arena *arena, WalkLight *out, Error *error) {
    const CellGraph *graph = &scene->graph;
    MeshOptions options;
    Arena scratch = {0};
    float *doors = ARENA_ARRAY(arena, float, scene->building.opening_count + 1);
    Mesh *mesh = ARENA_ARRAY(arena, Mesh, 1);
    RadSolution *solution = ARENA_ARRAY(arena, RadSolution, 1);
    bool good = rad_load_options(path, &scene->building, arena, &options, doors, error);
    if (good) {
        Vec3 *vertices = vis_posed(graph, doors, &scratch);
        options.proxies = proxies_find(graph, vertices, options.proxy, arena);
        good = mesh_build(graph, vertices, doors, &options, arena, mesh, error) &&
               rad_load(path, mesh, doors, arena, solution, error) &&
               (!scene->day_given || light_check_day(path, solution, &scene->day, error));
    }
    arena_free(&scratch);
    if (!good) return false;
    if (show_finer(mesh, solution, doors, arena, out, error)) return true;
    Error reason = *error;
    return error_set(error, "%s: %.900s", path, reason.text);
}

bool light_find(const LoadedScene *scene, bool given, Arena *arena, const WalkLight **out, Error *error) {
    WalkLight *found = ARENA_ARRAY(arena, WalkLight, 1);
    *out = NULL;
    for (int i = 0; i < scene->light_count; i++) {
        if (light_load(scene->lights[i], scene, arena, found, error)) {
            *out = found;
            return true;
        }
        if (given) return false;
        Error sentence;
        error_set(&sentence, "passed over: %.900s", error->text);
        if (scene->warn) scene->warn(sentence.text);
    }
    return true;
}

// ---- baking

// A scene to be baked; `out` is NULL where there is no place to store the light.
typedef struct SceneBake {
    const LoadedScene *scene;
    const char *out;
} SceneBake;

typedef struct Shower {
    const LightHooks *hooks;
    const FineMesh *fine;
    // When light was shown last, seconds.
    double shown;
} Shower;

static bool show_is_due(void *context) {
    const Shower *shower = context;
    return clock_seconds() - shower->shown >= shower->hooks->show_every;
}

static void show_solution(void *context, const RadSolution *so_far) {
    Shower *shower = context;
    Arena scratch = {0};
    WalkLight shown = show_fine(shower->fine, so_far, NULL, &scratch);
    shower->hooks->show(shower->hooks->context, shown.mesh, shown.solution);
    arena_free(&scratch);
    shower->shown = clock_seconds();
}

// The light of the lamps, and by day that of sky and sun.
static bool begin_light(const BakeOptions *options, const StabForest *forest, const float *doors,
                        const Progress *progress, const Mesh *mesh, Arena *arena, RadSolution *out,
                        Error *error) {
    if (!daylight_shines(&options->day)) return rad_start(mesh, arena, out, error);
    if (!rad_start_dark(mesh, arena, out, error)) return false;
    if (!rad_shine(mesh, forest, doors, &options->rad, &options->day, progress, out))
        return error_set(error, "stopped");
    if (rgb_sum(out->emitted) > 0) return true;
    return error_set(error, "nothing emits light, and no daylight comes in");
}

static bool bake_scene(void *context, const LightHooks *hooks, Arena *arena, WalkLight *out, Error *error) {
    const SceneBake *bake = context;
    BakeOptions options = bake_default_options();
    Mesh *mesh = ARENA_ARRAY(arena, Mesh, 1);
    RadSolution *solution = ARENA_ARRAY(arena, RadSolution, 1);
    Shower shower = {.hooks = hooks};
    float *doors;
    const StabForest *forest = &bake->scene->forest;
    options.rad.threads = hooks->threads;
    options.day = bake->scene->day;
    if (!bake_mesh(&options, bake->scene, NULL, &hooks->progress, arena, &doors, mesh, error) ||
        !progress_report(&hooks->progress, "mesh", 0))
        return false;
    rad_fit(mesh, &options.rad);
    if (!begin_light(&options, forest, doors, &hooks->progress, mesh, arena, solution, error)) return false;
    shower.fine = fine_mesh_new(mesh, arena);
    if (hooks->show) {
        show_solution(&shower, solution);
        options.rad.show = show_solution;
        options.rad.show_due = show_is_due;
        options.rad.show_context = &shower;
    }
    RadReport report = rad_shoot(mesh, forest, doors, &options.rad, &hooks->progress, solution);
    if (report.stopped) return error_set(error, "stopped");
    if (hooks->show) show_solution(&shower, solution);
    if (!direct_show(mesh, forest, doors, hooks->threads, &hooks->progress, arena, solution, NULL) ||
        !show_finer(mesh, solution, doors, arena, out, error))
        return error_set(error, "stopped");
    *error = (Error){""};
    if (bake->out) rad_save(bake->out, mesh, doors, solution, error);
    return true;
}

LightBaker light_baker(LoadedScene *scene, Arena *arena) {
    Error error;
    bool lit = scene_emits(scene) || daylight_shines(&scene->day);
    if (!lit || !scene_has_walls(scene, &error)) return (LightBaker){0};
    SceneBake *bake = ARENA_ARRAY(arena, SceneBake, 1);
    *bake = (SceneBake){scene, light_place(&scene->building, arena)};
    if (!scene_cache_takes(scene, bake->out, LIGHT_ROOM)) bake->out = NULL;
    return (LightBaker){bake_scene, bake, .keeps = bake->out != NULL};
}

// ---- stored light that is read later

typedef struct StoredLight {
    const LoadedScene *scene;
    bool asked;
    LightBaker otherwise;  // bakes what cannot be read
} StoredLight;

static bool read_or_bake(void *context, const LightHooks *hooks, Arena *arena, WalkLight *out, Error *error) {
    const StoredLight *stored = context;
    const LightBaker *baker = &stored->otherwise;
    const WalkLight *found;
    if (!light_find(stored->scene, stored->asked, arena, &found, error)) return false;
    *error = (Error){""};
    if (found) *out = *found;
    return found || (baker->bake && baker->bake(baker->context, hooks, arena, out, error));
}

static LightBaker stored_light(const LoadedScene *scene, bool asked, LightBaker otherwise, Arena *arena) {
    StoredLight *stored = ARENA_ARRAY(arena, StoredLight, 1);
    *stored = (StoredLight){scene, asked, otherwise};
    return (LightBaker){read_or_bake, stored, .stored = true, .asked = asked};
}

// ---- loading a building to walk through

bool walk_scene_load(void *context, const char *path, Arena *arena, WalkScene *out, Error *error) {
    SceneOptions *load = context;
    LoadedScene *scene = ARENA_ARRAY(arena, LoadedScene, 1);
    if (!scene_load(path, load, arena, scene, error) || !scene_has_walls(scene, error)) return false;
    *out = (WalkScene){.scene = scene, .graph = &scene->graph, .forest = &scene->forest};
    bool later = load->light_later && scene->light_count > 0;
    if (!later && !light_find(scene, load->light != NULL, arena, &out->light, error)) return false;
    if (!out->light && load->lamps == SCENE_LAMPS_ALL) out->baker = light_baker(scene, arena);
    if (later) out->baker = stored_light(scene, load->light != NULL, out->baker, arena);
    load->gentle = true;
    return true;
}
