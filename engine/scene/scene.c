// scene.c - from a building's file to a scene.
#include "engine/scene/scene.h"

#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "engine/core/clock.h"
#include "engine/core/file.h"
#include "engine/core/memory.h"
#include "engine/scene/budget.h"
#include "maps/building/lamp_faces.h"
#include "maps/maps.h"
#include "radiosity/shoot/shoot.h"
#include "visibility/prepare/prepare.h"

SceneOptions scene_default_options(void) {
    return (SceneOptions){.vis = vis_default_options(), .day = day_default_options(), .keep = true};
}

// ---- files

char *scene_cache_path(Arena *arena, const char *name) {
    char *folder;
    return file_cache_folder(arena, &folder, NULL) ? arena_format(arena, "%s/%s", folder, name) : NULL;
}

bool scene_cache_check(const char *path, size_t size, Error *error) {
    Arena scratch = {0};
    char *folder;
    struct stat info;
    bool good = file_cache_folder(&scratch, &folder, error) && file_make_folder(folder, error);
    if (good && stat(path, &info) == 0 && !S_ISREG(info.st_mode))
        good = error_set(error, "%s: is in the way: it is no regular file", path);
    good = good && file_check(path, size, error);
    arena_free(&scratch);
    return good;
}

static void warn(const LoadedScene *scene, const char *format, const char *reason) {
    Error sentence;
    error_set(&sentence, format, reason);
    if (scene->warn) scene->warn(sentence.text);
}

bool scene_cache_takes(LoadedScene *scene, const char *path, size_t size) {
    Error reason;
    if (scene_cache_check(path, size, &reason)) return true;
    if (!scene->no_cache)
        warn(scene, "%.900s: visibility and light are not kept (bake -o OUT.rad stores light elsewhere)",
             reason.text);
    scene->no_cache = true;
    return false;
}

bool scene_spares(const char *const *written, int write_count, const char *const *read, int read_count,
                  Error *error) {
    for (int i = 0; i < write_count; i++)
        for (int k = 0; k < read_count; k++)
            if (written[i] && read[k] && file_same(written[i], read[k]))
                return error_set(error, "%s: is read, and would be overwritten (allowed: another file)",
                                 written[i]);
    return true;
}

// ---- light files

// A given file must fit; one that was found and does not fit is passed over with a warning.
static bool take_light(const char *file, const SceneOptions *options, LoadedScene *scene, Error *error) {
    Error reason;
    MeshOptions mesh;
    Arena scratch = {0};
    if (!scene_spares(options->written, options->written_count, &file, 1, error)) return false;
    float *doors = ARENA_ARRAY(&scratch, float, scene->building.opening_count + 1);
    bool good = rad_load_options(file, &scene->building, &scratch, &mesh, doors, &reason);
    arena_free(&scratch);
    if (good) {
        scene->lights[scene->light_count++] = file;
        return true;
    }
    if (options->light) return error_set(error, "%s", reason.text);
    warn(scene, "passed over: %.900s", reason.text);
    return true;
}

// The light beside the building is FILE with the suffix .rad; the cache has it under the building's hash.
static bool find_lights(const char *path, const SceneOptions *options, Arena *arena, LoadedScene *scene,
                        Error *error) {
    if (options->light) return take_light(options->light, options, scene, error);
    const char *slash = strrchr(path, '/'), *dot = strrchr(slash ? slash : path, '.');
    int length = (int)(dot ? dot - path : (long)strlen(path));
    const char *places[SCENE_LIGHTS] = {
        arena_format(arena, "%.*s.rad", length, path),
        scene_cache_path(arena,
                         arena_format(arena, "%016llx.rad", (unsigned long long)scene->building.hash))};
    for (int i = 0; i < SCENE_LIGHTS; i++)
        if (places[i] && access(places[i], F_OK) == 0 && !take_light(places[i], options, scene, error))
            return false;
    return true;
}

// ---- loading

// By day where light is found that was made by day.
static bool is_day(const LoadedScene *scene) {
    Error reason;
    Daylight day;
    if (daylight_shines(&scene->day) || scene->day_given) return daylight_shines(&scene->day);
    return scene->light_count > 0 && rad_load_day(scene->lights[0], &scene->building, &day, &reason) &&
           daylight_shines(&day);
}

// The cells tell the rooms. They are made once more with the lamps, of which those of a soup are part.
static bool fill_rooms(const char *path, const SceneOptions *options, Arena *arena, LoadedScene *out,
                       Error *error) {
    Building *b = &out->building;
    Arena scratch = {0};
    CellGraph graph;
    if (options->fill_lamps == FILL_LAMPS_OFF || b->form == FORM_CELLS) return true;
    memory_set_stage("making cells");
    bool good = vis_build_cells(b, &options->vis, &scratch, &graph, error) && memory_within(error);
    if (good) fill_lamps_add(&graph, is_day(out), arena, b, &out->filled_rooms);
    arena_free(&scratch);
    Error sentence;
    if (b->fill_lamps == 0 || !out->warn) return good;
    error_set(&sentence, "%s: %d plain lamp%s added in %d room%s without light (--fill-lamps off: none)",
              path, b->fill_lamps, b->fill_lamps > 1 ? "s were" : " was", out->filled_rooms,
              out->filled_rooms > 1 ? "s" : "");
    out->warn(sentence.text);
    return good;
}

static bool read_building(const char *path, const SceneOptions *options, Arena *arena, LoadedScene *out,
                          Error *error) {
    *out = (LoadedScene){.warn = options->warn};
    double start = clock_seconds();
    budget_open(path, options->memory, options->gentle);
    if (!maps_read_map(path, options->map, arena, &out->building, error) ||
        !scene_spares(options->written, options->written_count, out->building.beside,
                      out->building.beside_count, error) ||
        !day_over(&options->day, &out->building, &out->day, error) ||
        (options->find_light && !find_lights(path, options, arena, out, error)))
        return false;
    out->day_given = day_asks(&options->day) || options->day.night;
    if (options->day.usual && !out->day_given && out->light_count == 0) day_usual(&out->building, &out->day);
    bool good = true;
    if (options->lamps == SCENE_LAMPS_ALL || (options->lamps == SCENE_LAMPS_IF_LIT && out->light_count > 0)) {
        out->lamp_faces = lamp_faces_add(arena, &out->building);
        good = fill_rooms(path, options, arena, out, error);
    }
    out->read_seconds = clock_seconds() - start;
    return good;
}

bool scene_load_cells(const char *path, const SceneOptions *options, Arena *arena, LoadedScene *out,
                      Error *error) {
    if (!read_building(path, options, arena, out, error)) return false;
    double start = clock_seconds();
    memory_set_stage("making cells");
    if (!vis_build_cells(&out->building, &options->vis, arena, &out->graph, error) || !memory_within(error))
        return false;
    memory_lower_fence();
    out->cells_seconds = clock_seconds() - start;
    return true;
}

// The caller's progress, ended where the building takes more memory than there is for it; notes when cells were there.
typedef struct Watch {
    const Progress *progress;
    double cells_made;
} Watch;

static bool report(void *context, const char *stage, double done) {
    Watch *watch = context;
    if (watch->cells_made > 0) return progress_report(watch->progress, stage, done) && memory_within(NULL);
    watch->cells_made = clock_seconds();
    return true;
}

bool scene_load(const char *path, const SceneOptions *options, Arena *arena, LoadedScene *out, Error *error) {
    if (!read_building(path, options, arena, out, error)) return false;
    double start = clock_seconds();
    VisPrepareOptions prepare = {.vis = options->vis, .fresh = options->fresh, .read_only = !options->keep};
    // In a soup every polygon takes part in the making of cells.
    bool soup = out->building.form == FORM_SOUP;
    const char *lamps = "";
    if (soup && out->lamp_faces > 0) lamps = "-lamps";
    if (soup && out->building.fill_lamps > 0)
        lamps = arena_format(arena, "-fill-%d", out->building.fill_lamps);
    prepare.file = scene_cache_path(
        arena, arena_format(arena, "%016llx%s.vis", (unsigned long long)out->building.hash, lamps));
    bool there = prepare.file && !options->fresh && access(prepare.file, R_OK) == 0;
    if (options->keep && !there) prepare.read_only = !scene_cache_takes(out, prepare.file, 0);
    Watch watch = {&options->progress, 0};
    Progress progress = {report, &watch};
    VisPrepared vis;
    if (!vis_prepare(&out->building, &prepare, &progress, arena, &vis, error)) return false;
    out->graph = vis.graph;
    out->forest = vis.forest;
    out->cached = vis.read;
    out->kept = vis.kept;
    out->stopped = vis.stopped;
    out->undecided = vis.undecided;
    if (*vis.not_read.text) warn(out, "%.900s; it is made anew", vis.not_read.text);
    if (*vis.not_kept.text) warn(out, "%.900s; going on without a cache", vis.not_kept.text);
    if (!memory_within(error)) return false;
    budget_work(path, options->memory, options->work ? options->work : "working on it");
    out->cells_seconds = watch.cells_made - start;
    out->trees_seconds = clock_seconds() - watch.cells_made;
    return true;
}

bool scene_has_walls(const LoadedScene *scene, Error *error) {
    if (scene->building.form != FORM_CELLS) return true;
    return error_set(
        error,
        "%s: holds cells and portals without walls: nothing to draw or to walk on (info, vis and "
        "bench take it)",
        scene->building.source);
}

bool scene_emits(const LoadedScene *scene) {
    const Building *b = &scene->building;
    for (int i = 0; i < b->material_count; i++) {
        Rgb e = b->materials[i].emission;
        if (e.r + e.g + e.b > 0) return true;
    }
    return false;
}
