// bake.c - a bake from a building's file to a .rad or .glb file: cells and stab trees, mesh, shooting, what to say of it.
#include "engine/app/bake.h"

#include <malloc.h>
#include <stdio.h>
#include <sys/resource.h>

#include "engine/app/export_glb.h"
#include "engine/core/clock.h"
#include "engine/core/file.h"
#include "engine/scene/light.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/final_gather.h"
#include "radiosity/show/fine_mesh.h"

// A share of light that escapes of less than this is rounding at the seams, not an open building.
static const double OPEN = 1e-6;

enum { MOST_NOTES = 5 };  // of what the reader changed or left out

typedef struct Bake {
    const BakeArguments *a;
    LoadedScene scene;
    float *doors;  // [opening_count]
    Mesh mesh;
    FineMesh *fine;  // with what stand-ins of `mesh` are for; NULL: not asked for yet
    RadSolution solution;
    RadSolution shown;  // on it
    RadOptions rad;     // as asked for, or as fits the mesh
    RadReport report;
    const char *out, *earlier;  // the .rad file, and the one that is resumed; NULL: none
    double mesh_seconds, sky_seconds, shoot_seconds, gather_seconds, seconds;
} Bake;

static double sum3(const double v[3]) { return v[0] + v[1] + v[2]; }

BakeArguments bake_default_arguments(void) {
    BakeArguments a = {.load = app_scene_options(), .bake = bake_default_options()};
    a.load.lamps = SCENE_LAMPS_ALL;
    a.load.work = "baking";
    return a;
}

static bool make_mesh(Bake *bake, Arena *arena, Error *error) {
    double start = clock_seconds();
    bool good =
        bake_mesh(&bake->a->bake, &bake->scene, bake->earlier, NULL, arena, &bake->doors, &bake->mesh, error);
    bake->mesh_seconds = clock_seconds() - start;
    bake->rad = bake->a->bake.rad;
    if (good) rad_fit(&bake->mesh, &bake->rad);
    return good;
}

// Where no .rad file is named, the light to resume is in the cache. Light that has no place there is made all the same.
static bool find_places(Bake *bake, Arena *arena, Error *error) {
    const BakeArguments *a = bake->a;
    bake->out = a->out;
    bool cached = !a->out && (!a->model || a->resume);
    if (cached) bake->out = light_place(&bake->scene.building, arena);
    if (a->resume && !(bake->earlier = bake->out))
        return error_set(error, "%s: there is no cache to resume from: give -o OUT.rad", a->file);
    if (cached && !scene_cache_takes(&bake->scene, bake->out, LIGHT_ROOM)) bake->out = NULL;
    return true;
}

// Is there room for the light? It is asked before hours of work rather than after them.
static bool check_room(Bake *bake, Error *error) {
    const Mesh *mesh = &bake->mesh;
    size_t bytes = (size_t)mesh->element_count * sizeof *bake->solution.radiosity +
                   (size_t)mesh->patch_count * sizeof *bake->solution.unshot;
    if (bake->a->out) return file_check(bake->a->out, bytes, error);
    if (bake->out && !scene_cache_takes(&bake->scene, bake->out, bytes)) bake->out = NULL;
    return true;
}

// A file tells under which sky it was made.
static bool check_sky(const Bake *bake, Error *error) {
    const double *had = bake->solution.sky, *sky = bake->a->bake.sky;
    if (memcmp(had, sky, sizeof bake->solution.sky) == 0) return true;
    return error_set(error, "%s: was made under a sky of %g,%g,%g W/m^2/sr (asked for: %g,%g,%g)",
                     bake->earlier, had[0], had[1], had[2], sky[0], sky[1], sky[2]);
}

static bool shine(Bake *bake, Error *error) {
    double start = clock_seconds();
    Progress progress = app_progress_stoppable(0);
    bool whole = rad_shine(&bake->mesh, &bake->scene.forest, bake->doors, &bake->rad, bake->a->bake.sky,
                           &progress, &bake->solution);
    app_progress_end();
    bake->sky_seconds = clock_seconds() - start;
    if (!whole) return error_set(error, "stopped before all daylight was in: nothing is stored");
    if (sum3(bake->solution.emitted) > 0) return true;
    return error_set(error, "nothing emits light, and none of the sky's comes in");
}

static bool begin_light(Bake *bake, Arena *arena, Error *error) {
    if (bake->a->resume)
        return rad_load(bake->earlier, &bake->mesh, bake->doors, arena, &bake->solution, error) &&
               check_sky(bake, error);
    bool day = sum3(bake->a->bake.sky) > 0;
    bool good = day ? rad_start_dark(&bake->mesh, arena, &bake->solution, error)
                    : rad_start(&bake->mesh, arena, &bake->solution, error);
    if (good && day) good = shine(bake, error);
    if (good) return true;
    Error reason = *error;
    return error_set(error, "%s: %.900s", bake->a->file, reason.text);
}

// The bar with the time that is left, as the stage goes on at its mean speed, or until a limit of time stops it.
typedef struct Timed {
    Progress bar;
    double start;
    // Seconds, 0: none; and whether they have passed.
    double limit;
    bool over;
} Timed;

static bool report_timed(void *context, const char *stage, double done) {
    Timed *timed = context;
    double seconds = clock_seconds() - timed->start;
    if (timed->limit > 0) done = fmin(fmax(done, seconds / timed->limit), 1);
    char line[96];
    if (done > 0.02)
        snprintf(line, sizeof line, "%s, %.0f s left", stage, seconds * (1 - done) / done);
    else
        snprintf(line, sizeof line, "%s", stage);
    if (!progress_report(&timed->bar, line, done)) return false;
    timed->over = timed->limit > 0 && seconds >= timed->limit;
    return !timed->over;
}

// At all nodes, of what was shot now: what an earlier run gathered is of the past.
static void gather_nodes(Bake *bake, Arena *arena) {
    bake->solution.node = NULL;
    bake->solution.node_count = 0;
    if (!bake->a->final_gather || bake->report.stopped) return;
    Arena scratch = {0};
    Timed timed = {.bar = app_progress_stoppable(0), .start = clock_seconds()};
    Progress progress = {report_timed, &timed};
    VertexLight light = reconstruct_light(&bake->mesh, &bake->solution, &scratch);
    GatherScene scene = {&bake->mesh, &bake->scene.forest, bake->doors, &bake->solution, &light};
    GatherOptions options = gather_default_options();
    bake->report.stopped =
        !final_gather(&scene, &options, bake->rad.threads, &progress, arena, &bake->solution);
    app_progress_end();
    bake->gather_seconds = clock_seconds() - timed.start;
    arena_free(&scratch);
}

// The building as it is, lit.
static void light_fine(Bake *bake, Arena *arena) {
    if (!bake->a->model && bake->a->probes.count == 0) return;
    bake->fine = fine_mesh_new(&bake->mesh, arena);
    bake->shown = fine_light(bake->fine, &bake->solution, arena);
}

// A limit of time ends the shooting as a limit of shots does: the bake was not stopped.
static void shoot_light(Bake *bake) {
    Timed timed = {.bar = app_progress_stoppable(0), .start = clock_seconds(), .limit = bake->a->seconds};
    Progress progress = {report_timed, &timed};
    bake->rad.clock = clock_seconds;
    bake->report =
        rad_shoot(&bake->mesh, &bake->scene.forest, bake->doors, &bake->rad, &progress, &bake->solution);
    app_progress_end();
    bake->shoot_seconds = clock_seconds() - timed.start;
    if (timed.over) bake->report.stopped = false;
}

static bool store(const Bake *bake, Error *error) {
    const char *model = bake->a->model;
    return (!bake->out || rad_save(bake->out, &bake->mesh, bake->doors, &bake->solution, error)) &&
           (!model || export_glb(model, &bake->fine->mesh, &bake->shown, bake->doors, error));
}

static bool compute(Bake *bake, Arena *arena, Error *error) {
    const BakeArguments *a = bake->a;
    const char *written[] = {a->out, a->model}, *read[] = {a->file, a->probe_file};
    SceneOptions load = a->load;
    if (!app_check_files(written, 2, read, 2, &load, error) ||
        !app_load(a->file, &load, arena, &bake->scene, error) || !find_places(bake, arena, error) ||
        !make_mesh(bake, arena, error) || !check_room(bake, error) || !begin_light(bake, arena, error))
        return false;
    shoot_light(bake);
    gather_nodes(bake, arena);
    light_fine(bake, arena);
    return store(bake, error);
}

static double peak_mb(void) {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)usage.ru_maxrss / 1024;
}

// The power of the lamps, W; the rest came from the sky.
static double lamp_power(const Mesh *mesh) {
    double power = 0;
    for (int p = 0; p < mesh->patch_count; p++) {
        Rgb e = mesh_material(mesh, mesh->patches[p].face)->emission;
        power += ((double)e.r + (double)e.g + (double)e.b) * mesh->patches[p].area;
    }
    return power;
}

static void add_proxies(json_t *facts, const Proxies *proxies) {
    json_object_set_new(facts, "proxy_objects", json_integer(proxies ? proxies->object_count : 0));
    json_object_set_new(facts, "proxy_polygons_before", json_integer(proxies ? proxies->replaced_count : 0));
    json_object_set_new(facts, "proxy_polygons", json_integer(proxies ? proxies->polygon_count : 0));
}

static json_t *facts_of(const Bake *bake) {
    const RadReport *r = &bake->report;
    const RadSolution *s = &bake->solution;
    const RadOptions *rad = &bake->rad;
    double emitted = sum3(s->emitted);
    json_t *facts =
        json_pack("{s:i s:i s:i s:i s:I s:f s:I s:I s:f s:f s:f s:f s:f s:f s:f s:f s:f s:f s:f s:i s:f s:s "
                  "s:i s:s s:f s:f}",
                  "cells", bake->scene.graph.cell_count, "polygons", bake->mesh.face_count, "patches",
                  bake->mesh.patch_count, "elements", bake->mesh.element_count, "shots", (json_int_t)s->shots,
                  "residual", r->residual, "rows_made", (json_int_t)r->rows_made, "rows_kept",
                  (json_int_t)r->rows_kept, "row_mb", (double)r->row_bytes / (1 << 20), "elements_drawn_mean",
                  r->elements_drawn_mean, "polygons_drawn_mean", r->faces_drawn_mean, "emitted", emitted,
                  "absorbed", sum3(s->absorbed) / emitted, "escaped", sum3(s->escaped) / emitted, "seconds",
                  bake->seconds, "seconds_mesh", bake->mesh_seconds, "seconds_shooting", bake->shoot_seconds,
                  "seconds_visibility", r->seconds_visibility, "seconds_gather", bake->gather_seconds,
                  "nodes", s->node_count, "peak_mb", peak_mb(), "method", rad->method->name, "resolution",
                  rad->form_factor.resolution, "culling", VIEW_CULLING_NAMES[rad->culling], "sky",
                  sum3(s->sky) > 0 ? fmax(emitted - lamp_power(&bake->mesh), 0) : 0.0, "seconds_sky",
                  bake->sky_seconds);
    CORE_ASSERT(facts);
    add_proxies(facts, bake->mesh.options.proxies);
    if (bake->out) json_object_set_new(facts, "file", json_string(bake->out));
    if (bake->a->model) json_object_set_new(facts, "model", json_string(bake->a->model));
    json_object_set_new(facts, "stopped", json_boolean(r->stopped));
    return facts;
}

static void print_facts(json_t *facts) {
    const char *key;
    json_t *value;
    json_object_foreach(facts, key, value) {
        if (json_is_integer(value)) printf("%-20s %lld\n", key, (long long)json_integer_value(value));
        if (json_is_real(value)) printf("%-20s %.6g\n", key, json_real_value(value));
        if (json_is_string(value)) printf("%-20s %s\n", key, json_string_value(value));
        if (json_is_boolean(value)) printf("%-20s %s\n", key, json_is_true(value) ? "yes" : "no");
    }
    json_decref(facts);
}

// Patches in no cell that light reaches all the same, where that is more than what goes to and fro between two faces that touch,
// of a wardrobe's back and of the wall behind.
static int lost_in_light(const Bake *bake) {
    static const double BETWEEN = 1e-4;  // of all that is emitted; in homes it is some millionths
    int lost = 0;
    double power = 0;
    for (int p = 0; p < bake->mesh.patch_count; p++) {
        const Patch *patch = &bake->mesh.patches[p];
        double sum = 0;
        if (patch->cell >= 0) continue;
        for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++)
            sum += sum3(bake->solution.radiosity[e]) * bake->mesh.elements[e].area;
        lost += sum > 0;
        power += sum;
    }
    return power > BETWEEN * sum3(bake->solution.emitted) ? lost : 0;
}

static void print_warnings(const Bake *bake) {
    const RadSolution *s = &bake->solution;
    const Mesh *mesh = &bake->mesh;
    app_print_notes(&bake->scene.building, MOST_NOTES);
    double escaped = sum3(s->escaped) / sum3(s->emitted);
    if (escaped > OPEN && sum3(s->sky) == 0)
        fprintf(stderr, "enfilade: %s is open: %.3g %% of its light escaped\n", bake->a->file, 100 * escaped);
    int lost = lost_in_light(bake);
    if (lost > 0)
        fprintf(stderr, "enfilade: %d of %d patches are lit but lie in no cell: nothing is culled for them\n",
                lost, mesh->patch_count);
    if (mesh->dropped_faces > 0)
        fprintf(stderr, "enfilade: %d polygons without area were left out\n", mesh->dropped_faces);
}

// Elements count as constant: slopes would enlarge the errors of elements in corners, where shooters are near.
static void gather_probes(const Bake *bake, Probes *probes) {
    if (probes->count == 0) return;
    GatherScene scene = {&bake->fine->mesh, &bake->scene.forest, bake->doors, &bake->shown, NULL};
    bake_probes_gather(&scene, probes);
}

static void print_bake(Bake *bake) {
    BakeArguments a = *bake->a;
    json_t *facts = facts_of(bake);
    gather_probes(bake, &a.probes);
    if (a.json) {
        if (a.probes.count > 0) json_object_set_new(facts, "probes", bake_probes_json(&a.probes));
        app_print_json(facts);
    } else {
        print_facts(facts);
        bake_probes_print(&a.probes);
    }
    print_warnings(bake);
}

// Meshes and what is solved on them are made and let go one after the other: their memory is kept for the next, as to ask the
// system for it takes longer than to fill it.
static void keep_memory(void) {
    mallopt(M_MMAP_THRESHOLD, 64 << 20);
    mallopt(M_TRIM_THRESHOLD, 128 << 20);
}

int bake(BakeArguments *arguments) {
    keep_memory();
    Bake b = {.a = arguments};
    Arena arena = {0};
    Error error;
    double start = clock_seconds();
    bool good = compute(&b, &arena, &error);
    b.seconds = clock_seconds() - start;
    if (good) print_bake(&b);
    arena_free(&arena);
    return good ? APP_GOOD : app_fail(APP_BAD_INPUT, "%s", error.text);
}
