// scene.c - from a building's file to a scene.
#include "engine/scene/scene.h"

#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "engine/core/clock.h"
#include "engine/core/file.h"
#include "engine/core/memory.h"
#include "engine/scene/budget.h"
#include "engine/scene/lamp_state.h"
#include "engine/scene/light_parts.h"
#include "maps/building/lamp_faces.h"
#include "maps/maps.h"
#include "maps/photometry/photometry_file.h"
#include "visibility/prepare/prepare.h"

SceneOptions scene_default_options(void) {
    return (SceneOptions){.vis = vis_default_options(),
                          .day = day_default_options(),
                          .turned_from = day_default_options(),
                          .keep = true};
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
    Daylight day;
    if (!scene_spares(options->written, options->written_count, &file, 1, error)) return false;
    if (light_stored_day(file, &scene->building, &day, &reason)) {
        if (scene->light_count == 0) scene->light_day = day;
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
    return daylight_shines(&scene->day) || (!scene->day_given && daylight_shines(&scene->light_day));
}

static bool make_cells(const SceneOptions *options, Arena *arena, LoadedScene *out, Error *error) {
    double start = clock_seconds();
    memory_set_stage("making cells");
    bool good =
        vis_build_cells(&out->building, &options->vis, arena, &out->graph, error) && memory_within(error);
    out->cells_seconds += clock_seconds() - start;
    return good;
}

// The cells tell the rooms. Where rooms get lamps the cells are made once more with them, of which those of a soup are part; else they
// stay.
static bool fill_rooms(const char *path, const SceneOptions *options, Arena *arena, LoadedScene *out,
                       Error *error) {
    Building *b = &out->building;
    Arena cells = {0};
    if (options->fill_lamps == FILL_LAMPS_OFF || b->form == FORM_CELLS) return true;
    bool good = make_cells(options, &cells, out, error);
    if (good) fill_lamps_add(&out->graph, is_day(out), arena, b, &out->filled_rooms);
    if (good && b->fill_lamps == 0)
        arena_join(arena, &cells);
    else
        out->graph = (CellGraph){0};
    arena_free(&cells);
    Error sentence;
    if (b->fill_lamps == 0 || !out->warn) return good;
    error_set(&sentence, "%s: %d plain lamp%s added in %d room%s without light (--fill-lamps off: none)",
              path, b->fill_lamps, b->fill_lamps > 1 ? "s were" : " was", out->filled_rooms,
              out->filled_rooms > 1 ? "s" : "");
    out->warn(sentence.text);
    return good;
}

static bool take_photometry(const SceneOptions *options, Arena *arena, Building *b, Error *error) {
    for (int i = 0; i < options->photometry.count; i++)
        if (!photometry_for_name(options->photometry.text[i], arena, b, error)) return false;
    return true;
}

static bool read_building(const char *path, const SceneOptions *options, Arena *arena, LoadedScene *out,
                          Error *error) {
    *out = (LoadedScene){.warn = options->warn};
    double start = clock_seconds();
    DayOptions day = options->day;
    budget_open(path, options->memory, options->gentle);
    if (!maps_read_map(path, options->map, arena, &out->building, error) ||
        !take_photometry(options, arena, &out->building, error) ||
        !scene_spares(options->written, options->written_count, out->building.beside,
                      out->building.beside_count, error))
        return false;
    if (options->turned)
        day = day_at_hour(&options->turned_from, &out->building,
                          options->turned_from.time[0] + options->turned / 60.0);
    if (!day_over(&day, &out->building, &out->day, error) ||
        (options->find_light && !options->turned && !find_lights(path, options, arena, out, error)))
        return false;
    out->day_given = day_asks(&day) || day.night;
    if (day.usual && !out->day_given) {
        // Stored light that turns out to be damaged is baked anew under its own day.
        out->day = out->light_day;
        if (out->light_count == 0) day_usual(&out->building, &out->day);
    }
    bool good = true;
    if (options->lamps == SCENE_LAMPS_ALL || (options->lamps == SCENE_LAMPS_IF_LIT && out->light_count > 0)) {
        out->lamp_faces = lamp_faces_add(arena, &out->building);
        good = fill_rooms(path, options, arena, out, error);
    }
    out->read_seconds = clock_seconds() - start - out->cells_seconds;
    return good;
}

// The graph begins with a copy of the building's own polygons. Where it is the same to the last bit, the building uses the copy: in a large
// building a tenth of all memory.
static void share_polygons(LoadedScene *scene, Arena *arena) {
    Building *b = &scene->building;
    const CellGraph *graph = &scene->graph;
    size_t polygons = (size_t)b->polygon_count * sizeof *b->polygons,
           vertices = (size_t)b->vertex_count * sizeof *b->vertices;
    if (polygons + vertices == 0 || b->polygon_count >= graph->polygon_count ||
        b->vertex_count >= graph->vertex_count || memcmp(b->polygons, graph->polygons, polygons) != 0 ||
        memcmp(b->vertices, graph->vertices, vertices) != 0)
        return;
    arena_release(arena, b->polygons);
    arena_release(arena, b->vertices);
    b->polygons = graph->polygons;
    b->vertices = graph->vertices;
    // Whoever adds to them later gets arrays of their own.
    b->polygon_capacity = b->polygon_count;
    b->vertex_capacity = b->vertex_count;
}

bool scene_load_cells(const char *path, const SceneOptions *options, Arena *arena, LoadedScene *out,
                      Error *error) {
    if (!read_building(path, options, arena, out, error)) return false;
    if (out->graph.cell_count == 0 && !make_cells(options, arena, out, error)) return false;
    share_polygons(out, arena);
    lamps_find(&out->graph, &out->building, arena, &out->lamps);
    out->lit = ARENA_ARRAY(arena, Rgb, out->lamps.count + 1);
    for (int i = 0; i < out->lamps.count; i++) out->lit[i] = (Rgb){1, 1, 1};
    if (options->lamp_state && !lamp_state_apply(&out->lamps, options->lamp_state, out->lit, error))
        return false;
    memory_lower_fence();
    return true;
}

// The caller's progress, ended where the building takes more memory than there is for it.
static bool report(void *context, const char *stage, double done) {
    const Progress *progress = context;
    return progress_report(progress, stage, done) && memory_within(NULL);
}

bool scene_load(const char *path, const SceneOptions *options, Arena *arena, LoadedScene *out, Error *error) {
    if (!scene_load_cells(path, options, arena, out, error)) return false;
    double start = clock_seconds();
    VisPrepareOptions prepare = {
        .vis = options->vis, .graph = &out->graph, .fresh = options->fresh, .read_only = !options->keep};
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
    Progress wanted = options->progress, progress = {report, &wanted};
    VisPrepared vis;
    if (!vis_prepare(&out->building, &prepare, &progress, arena, &vis, error)) return false;
    out->forest = vis.forest;
    out->cached = vis.read;
    out->kept = vis.kept;
    out->stopped = vis.stopped;
    out->undecided = vis.undecided;
    if (*vis.not_read.text) warn(out, "%.900s; it is made anew", vis.not_read.text);
    if (*vis.not_kept.text) warn(out, "%.900s; going on without a cache", vis.not_kept.text);
    if (!memory_within(error)) return false;
    budget_work(path, options->memory, options->work ? options->work : "working on it");
    out->trees_seconds = clock_seconds() - start;
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

bool scene_fully_lit(const LoadedScene *scene) {
    for (int i = 0; i < scene->lamps.count; i++) {
        Rgb lit = scene->lit[i];
        if (lit.r != 1 || lit.g != 1 || lit.b != 1) return false;
    }
    return true;
}

Mesh scene_lit_mesh(const LoadedScene *scene, const Mesh *mesh, Arena *arena) {
    return scene_fully_lit(scene) ? *mesh : lamps_mesh(&scene->lamps, mesh, scene->lit, arena);
}
