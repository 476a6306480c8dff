// cmd_bake.c - `enfilade bake FILE`: computes the light of a building by radiosity, and stores it.
#include <limits.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/resource.h>

#include "engine/app/app.h"
#include "engine/app/bake_probes.h"
#include "engine/app/export_glb.h"
#include "engine/core/clock.h"
#include "engine/core/file.h"
#include "engine/lit/lit_part.h"
#include "engine/scene/bake_parts.h"
#include "engine/scene/kept_parts.h"
#include "engine/scene/light.h"
#include "radiosity/follow/each_lamp.h"
#include "radiosity/follow/relight.h"
#include "radiosity/shoot/shoot_rows.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/direct.h"
#include "radiosity/show/final_gather.h"
#include "radiosity/show/fine_mesh.h"
#include "radiosity/show/shown.h"
#include "visibility/hidden/hidden.h"

typedef struct BakeArguments {
    SceneOptions load;
    BakeOptions bake;
    const char *file;
    // .rad and .glb, NULL: none; both NULL: a .rad into the cache
    const char *out, *model;
    // `each`: the light of each lamp by itself, too.
    bool final_gather, resume, json, each;
    // The limit of the whole bake, seconds; 0: none.
    double seconds;
    // In parts of so many cells at most; 0: as a whole. What was found is kept every so many seconds; 0: every DEFAULT_CHECKPOINT.
    int parts;
    bool apart;  // and stored so
    double checkpoint;
    Probes probes;
    // The file that probes were read from, the last one; NULL: none.
    const char *probe_file;
} BakeArguments;

// ---- a bake from a building's file to a .rad or .glb file: cells and stab trees, mesh, shooting, report.

// A share of light that escapes of less than this is rounding at the seams, not an open building.
static const double OPEN = 1e-6;

// The shares of a limit of time after which a mesh that follows the light is given up, and after which shooting ends: the rest is for
// the light straight from lamps, which in furnished homes takes about as long as shooting.
static const double MESH_TIME = 0.25, SHOOTING_TIME = 0.6;

enum { MOST_NOTES = 5 };  // on parts of the building that the reader changed or left out

typedef struct Bake {
    const BakeArguments *a;
    LoadedScene scene;
    float *doors;  // [opening_count]
    Mesh mesh;
    RadSolution solution;
    // The mesh that shows the light and `mesh`, each with the fine polygons that its stand-ins replace, and the light on them; NULL: no
    // model and no probes are asked for
    FineMesh *fine, *probed;
    RadSolution shown, probed_light;
    RadOptions rad;  // as asked for, or as fits the mesh
    RadReport report;
    PartsReport parts;          // of a bake in parts
    bool apart;                 // whose light is not joined: there are no mesh and solution, but for sums
    DirectSources *sources;     // of the light of each lamp, or NULL
    const char *out, *earlier;  // the .rad file, and the one that is resumed; NULL: none
    double start;               // of all, on the clock
    double mesh_seconds, sky_seconds, shoot_seconds, gather_seconds, direct_seconds, each_seconds, seconds;
    bool even,
        unlit;  // a limit of time gave up a mesh that follows the light, or the light straight from lamps
} Bake;

// The bar with the time that is left, as the stage goes on at its mean speed, or until a limit of time stops it.
typedef struct Timed {
    Progress bar;
    double start;
    // When it ends at the latest, on the clock, 0: never; and whether that moment has passed.
    double end;
    bool over;
} Timed;

static bool report_timed(void *context, const char *stage, double done) {
    Timed *timed = context;
    double now = clock_seconds(), seconds = now - timed->start;
    if (timed->end > 0) done = fmin(fmax(done, seconds / fmax(timed->end - timed->start, seconds)), 1);
    char line[96];
    if (done > 0.02)
        snprintf(line, sizeof line, "%s, %.0f s left", stage, seconds * (1 - done) / done);
    else
        snprintf(line, sizeof line, "%s", stage);
    if (!progress_report(&timed->bar, line, done)) return false;
    timed->over = timed->end > 0 && now >= timed->end;
    return !timed->over;
}

// A stage from now on, which ends when so much of the limit of time is over.
static Timed timed_stage(const Bake *bake, double share, Progress bar) {
    double limit = bake->a->seconds;
    return (Timed){.bar = bar, .start = clock_seconds(), .end = limit > 0 ? bake->start + share * limit : 0};
}

static BakeArguments bake_default_arguments(void) {
    BakeArguments a = {.load = app_scene_options(), .bake = bake_default_options()};
    a.load.lamps = SCENE_LAMPS_ALL;
    a.load.fill_lamps = FILL_LAMPS_ON;
    a.load.work = "baking";
    return a;
}

static bool make_mesh(Bake *bake, Arena *arena, Error *error) {
    double start = clock_seconds();
    BakeOptions options = bake->a->bake;
    options.day = bake->scene.day;
    // A user's Ctrl-C ends the program here: there is nothing to store.
    Timed timed = timed_stage(bake, MESH_TIME, (Progress){0});
    Progress progress = {report_timed, &timed};
    bool good =
        bake_mesh(&options, &bake->scene, bake->earlier, &progress, arena, &bake->doors, &bake->mesh, error);
    if (!good && timed.over) {
        options.adapt.share = 0;
        bake->even = true;
        good =
            bake_mesh(&options, &bake->scene, bake->earlier, NULL, arena, &bake->doors, &bake->mesh, error);
    }
    bake->mesh_seconds = clock_seconds() - start;
    bake->rad = bake->a->bake.rad;
    if (!good) return false;
    bake->mesh = scene_lit_mesh(&bake->scene, &bake->mesh, arena);
    bool fits = bake->rad.row_bytes == RAD_ROWS_FIT;
    rad_fit(&bake->mesh, &bake->rad);
    if (fits && bake->a->load.memory > 0 && bake->rad.row_bytes > bake->a->load.memory / 4)
        bake->rad.row_bytes = bake->a->load.memory / 4;
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

static bool shine(Bake *bake, Error *error) {
    double start = clock_seconds();
    Timed timed = timed_stage(bake, 1, app_progress_stoppable(0));
    Progress progress = {report_timed, &timed};
    bool whole = rad_shine(&bake->mesh, &bake->scene.forest, bake->doors, &bake->rad, &bake->scene.day,
                           &progress, &bake->solution);
    app_progress_end();
    bake->sky_seconds = clock_seconds() - start;
    if (!whole && timed.over)
        return error_set(error,
                         "all daylight was not in after %g s: nothing is stored (--seconds S allows more)",
                         bake->a->seconds);
    if (!whole) return error_set(error, "stopped before all daylight was in: nothing is stored");
    if (rgb_sum(bake->solution.emitted) > 0) return true;
    return error_set(error, "nothing emits light, and no daylight comes in");
}

// Where light is shot on, that of each lamp is out of date: it is dropped, and found anew where it is asked for.
static bool take_resumed_lamps(Bake *bake, Error *error) {
    RadSolution *s = &bake->solution;
    if (!light_take_lamps(bake->earlier, &bake->scene, s, error)) return false;
    s->each = NULL;
    s->each_count = 0;
    return true;
}

static bool begin_light(Bake *bake, Arena *arena, Error *error) {
    if (bake->a->resume)
        return rad_load(bake->earlier, &bake->mesh, bake->doors, arena, &bake->solution, error) &&
               light_check_day(bake->earlier, &bake->solution, &bake->scene.day, error) &&
               take_resumed_lamps(bake, error);
    bool day = daylight_shines(&bake->scene.day);
    bool good = day ? rad_start_dark(&bake->mesh, arena, &bake->solution, error)
                    : rad_start(&bake->mesh, arena, &bake->solution, error);
    if (good && day) good = shine(bake, error);
    bake->solution.lit = bake->scene.lit;
    bake->solution.lamp_count = bake->scene.lamps.count;
    if (good) return true;
    Error reason = *error;
    return error_set(error, "%s: %.900s", bake->a->file, reason.text);
}

// Finds the light straight from lamps at all nodes.
static void show_direct(Bake *bake, Arena *arena) {
    Timed timed = timed_stage(bake, 1, app_progress_stoppable(0));
    Progress progress = {report_timed, &timed};
    bool whole = direct_show_apart(&bake->mesh, &bake->scene.forest, bake->doors, bake->rad.threads,
                                   &progress, arena, &bake->solution, bake->sources, NULL, &bake->report);
    app_progress_end();
    bake->unlit = !whole && timed.over;
    bake->report.stopped = !whole && !timed.over;
    bake->direct_seconds = clock_seconds() - timed.start;
}

// Gathers light at all nodes from the present shooting. Light that an earlier run gathered is out of date.
static void gather_nodes(Bake *bake, Arena *arena) {
    bake->solution.node = NULL;
    bake->solution.node_count = 0;
    bake->solution.rest = NULL;
    bake->solution.shown = NULL;
    if (bake->report.stopped) return;
    if (!bake->a->final_gather) {
        show_direct(bake, arena);
        return;
    }
    Arena scratch = {0};
    Timed timed = timed_stage(bake, 1, app_progress_stoppable(0));
    Progress progress = {report_timed, &timed};
    VertexLight light = reconstruct_light(&bake->mesh, &bake->solution, &scratch);
    GatherScene scene = {&bake->mesh, &bake->scene.forest, bake->doors, &bake->solution, &light};
    GatherOptions options = gather_default_options();
    bool whole = final_gather(&scene, &options, bake->rad.threads, &progress, arena, &bake->solution);
    app_progress_end();
    bake->unlit = !whole && timed.over;
    bake->report.stopped = !whole && !timed.over;
    bake->gather_seconds = clock_seconds() - timed.start;
    arena_free(&scratch);
}

// The light of each lamp, along the rows of all light.
static void find_each(Bake *bake, Arena *arena) {
    RadSolution *s = &bake->solution;
    if (bake->report.stopped || bake->unlit || !s->gathered || !s->node) {
        app_warn("the light of each lamp is not known: light was not shot and shown to the end");
        return;
    }
    Timed timed = timed_stage(bake, 1, app_progress_stoppable(0));
    Progress progress = {report_timed, &timed};
    EachLamp each = {&bake->mesh, &bake->scene.lamps, &bake->scene.forest,
                     bake->doors, &bake->rad,         bake->sources};
    bool whole = each_lamp_find(&each, &progress, arena, s);
    app_progress_end();
    if (!whole && timed.over)
        app_warn("the light of each lamp is not known: there was not time enough (--seconds S allows more)");
    bake->report.stopped = !whole && !timed.over;
    bake->each_seconds = clock_seconds() - timed.start;
}

// The model is lit on the mesh that shows the light; probes read the elements that light was found on.
static bool light_fine(Bake *bake, Arena *arena, Error *error) {
    if (bake->a->probes.count > 0) {
        RadSolution found = bake->solution;
        found.node = NULL;
        found.node_count = 0;
        found.rest = NULL;
        found.shown = NULL;
        bake->probed = fine_mesh_new(&bake->mesh, arena);
        bake->probed_light = fine_light(bake->probed, &found, arena);
    }
    if (!bake->a->model) return true;
    const Mesh *mesh;
    const RadSolution *light;
    if (!shown_light(&bake->mesh, &bake->solution, bake->doors, arena, &mesh, &light, error)) return false;
    bake->fine = fine_mesh_new(mesh, arena);
    bake->shown = fine_light(bake->fine, light, arena);
    return true;
}

// A limit of time ends the shooting as a limit of shots does: the bake was not stopped.
static void shoot_light(Bake *bake) {
    Timed timed = timed_stage(bake, SHOOTING_TIME, app_progress_stoppable(0));
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

// Is anything asked for that only the light of the whole has?
static bool asks_for_whole(const BakeArguments *a) {
    return a->each || a->final_gather || a->seconds > 0 || a->bake.rad.shots > 0 || a->model ||
           a->probes.count > 0;
}

// A building whose light does not fit in memory is baked and stored in parts, unless the whole is asked for.
static bool goes_apart(const Bake *bake) {
    const BakeArguments *a = bake->a;
    return bake->out && (a->apart || (!asks_for_whole(a) && bake_parts_are_needed(&a->bake, &bake->scene)));
}

static int part_cells(const Bake *bake) {
    if (bake->a->parts > 0) return bake->a->parts;
    if (goes_apart(bake)) return bake_parts_cells_apart();
    return team_is_started() ? bake_parts_cells(&bake->scene.graph) : 0;
}

// How often the light of parts is kept, seconds, if nothing else is asked for: the files of ten thousand rooms take some seconds.
static const double DEFAULT_CHECKPOINT = 60;

// The first process of several stores the light.
static bool compute_parts(Bake *bake, Arena *arena, Error *error) {
    const BakeArguments *a = bake->a;
    BakeOptions options = a->bake;
    options.day = bake->scene.day;
    double start = clock_seconds();
    Timed timed = timed_stage(bake, 1, app_progress_stoppable(0));
    Progress progress = {report_timed, &timed};
    PartsKeep keep = {.folder = bake->out ? kept_folder(bake->out, arena) : NULL,
                      .seconds = a->checkpoint > 0 ? a->checkpoint : DEFAULT_CHECKPOINT,
                      .resume = a->resume,
                      .apart = goes_apart(bake) ? bake->out : NULL,
                      .drawn = lit_store_part};
    vis_share_query(&bake->scene.graph, &bake->scene.forest, arena);
    bool good = bake_parts(&options, &bake->scene, part_cells(bake), keep.folder ? &keep : NULL, &progress,
                           arena, &bake->doors, &bake->mesh, &bake->solution, &bake->parts, error);
    app_progress_end();
    if (*bake->parts.unkept.text) {
        Error sentence;
        error_set(&sentence, "the light so far is not kept: %.900s", bake->parts.unkept.text);
        app_warn(sentence.text);
    }
    bake->report = bake->parts.rad;
    bake->shoot_seconds = clock_seconds() - start;
    bake->rad = a->bake.rad;
    bake->apart = keep.apart != NULL;
    if (!good || team_rank() > 0) return good;
    if (bake->apart) {
        Mesh sized = {.patch_count = (int)bake->parts.patches, .element_count = (int)bake->parts.elements};
        rad_fit(&sized, &bake->rad);
        bake->solution = bake->parts.power;
        return true;
    }
    rad_fit(&bake->mesh, &bake->rad);
    if (!bake->solution.node)
        app_warn("the mesh that shows the light of all parts would be too large: shadows are as coarse as "
                 "elements");
    good = check_room(bake, error) && light_fine(bake, arena, error) && store(bake, error);
    if (good && keep.folder) kept_remove(keep.folder, INT_MAX, 0);
    return good;
}

static bool compute(Bake *bake, Arena *arena, Error *error) {
    const BakeArguments *a = bake->a;
    const char *written[] = {a->out, a->model}, *read[] = {a->file, a->probe_file};
    SceneOptions load = a->load;
    if (!app_check_files(written, 2, read, 2, &load, error) ||
        !app_load(a->file, &load, arena, &bake->scene, error) || !find_places(bake, arena, error))
        return false;
    if (part_cells(bake) > 0) return compute_parts(bake, arena, error);
    if (!make_mesh(bake, arena, error) || !check_room(bake, error) || !begin_light(bake, arena, error))
        return false;
    if (a->each) {
        bake->rad.rows = shoot_rows_new(&bake->mesh, &bake->scene.forest, bake->doors, &bake->rad,
                                        &bake->solution.day, arena);
        bake->sources = each_lamp_sources(&bake->mesh, &bake->scene.lamps, bake->rad.threads, arena);
        relight_prepare(bake->sources, &bake->mesh, arena);
    }
    shoot_light(bake);
    gather_nodes(bake, arena);
    if (a->each) {
        find_each(bake, arena);
        direct_sources_end(bake->sources);
        shoot_rows_end(bake->rad.rows);
    }
    return light_fine(bake, arena, error) && store(bake, error);
}

static double peak_mb(void) {
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)usage.ru_maxrss / 1024;
}

// The power of the lamps, W; the rest is daylight.
static double lamp_power(const Mesh *mesh) {
    double power = 0;
    for (int p = 0; p < mesh->patch_count; p++) {
        Rgb e = mesh_material(mesh, mesh->patches[p].face)->emission;
        power += ((double)e.r + (double)e.g + (double)e.b) * mesh->patches[p].area;
    }
    return power;
}

// The same where light was not joined.
static void add_sums(json_t *facts, const PartsReport *parts) {
    json_object_set_new(facts, "polygons", json_integer((json_int_t)parts->polygons));
    json_object_set_new(facts, "patches", json_integer((json_int_t)parts->patches));
    json_object_set_new(facts, "elements", json_integer((json_int_t)parts->elements));
    json_object_set_new(facts, "nodes", json_integer((json_int_t)parts->nodes));
    if (daylight_shines(&parts->power.day))
        json_object_set_new(facts, "sky_w",
                            json_real(fmax(rgb_sum(parts->power.emitted) - parts->lamp_watts, 0)));
}

static void add_proxies(json_t *facts, const Proxies *proxies) {
    json_object_set_new(facts, "proxy_objects", json_integer(proxies ? proxies->object_count : 0));
    json_object_set_new(facts, "proxy_polygons_before", json_integer(proxies ? proxies->replaced_count : 0));
    json_object_set_new(facts, "proxy_polygons", json_integer(proxies ? proxies->polygon_count : 0));
}

// Power ends in _w and is in watts, all channels together: emitted = absorbed + escaped + unshot. Shares end in _share.
static json_t *facts_of(const Bake *bake) {
    const RadReport *r = &bake->report;
    const RadSolution *s = &bake->solution;
    const RadOptions *rad = &bake->rad;
    double emitted = rgb_sum(s->emitted), absorbed = rgb_sum(s->absorbed), escaped = rgb_sum(s->escaped);
    json_t *facts = json_pack(
        "{s:i s:i s:i s:i s:I s:f s:I s:I s:f s:f s:f s:f s:f s:f s:f s:f s:f s:f s:f s:f s:f s:I s:I s:i "
        "s:f "
        "s:s "
        "s:i s:s s:f s:f}",
        "cells", bake->scene.graph.cell_count, "polygons", bake->mesh.face_count, "patches",
        bake->mesh.patch_count, "elements", bake->mesh.element_count, "shots", (json_int_t)s->shots,
        "residual_share", r->residual, "rows_made", (json_int_t)r->rows_made, "rows_kept",
        (json_int_t)r->rows_kept, "row_mb", (double)r->row_bytes / (1 << 20), "elements_drawn_mean",
        r->elements_drawn_mean, "polygons_drawn_mean", r->faces_drawn_mean, "emitted_w", emitted,
        "absorbed_w", absorbed, "escaped_w", escaped, "unshot_w", fmax(0, emitted - absorbed - escaped),
        "seconds", bake->seconds, "seconds_mesh", bake->mesh_seconds, "seconds_shooting", bake->shoot_seconds,
        "seconds_visibility", r->seconds_visibility, "seconds_gather", bake->gather_seconds, "seconds_direct",
        bake->direct_seconds, "direct_pairs", (json_int_t)r->direct_pairs, "direct_cut",
        (json_int_t)r->direct_cut, "nodes", s->node_count, "peak_mb", peak_mb(), "method", rad->method->name,
        "resolution", rad->form_factor.resolution, "culling", CULLING_NAMES[rad->culling], "sky_w",
        daylight_shines(&s->day) ? fmax(emitted - lamp_power(&bake->mesh), 0) : 0.0, "seconds_sky",
        bake->sky_seconds);
    CORE_ASSERT(facts);
    if (bake->apart) add_sums(facts, &bake->parts);
    json_object_set_new(facts, "lamps", json_integer(bake->scene.lamps.count));
    json_object_set_new(facts, "lamps_known", json_integer(s->each ? s->lamp_count : 0));
    json_object_set_new(facts, "lamps_mb", json_real((double)each_lamp_bytes(s) / (1 << 20)));
    json_object_set_new(facts, "seconds_lamps", json_real(bake->each_seconds));
    json_object_set_new(facts, "fill_lamps", json_integer(bake->scene.building.fill_lamps));
    add_proxies(facts, bake->mesh.options.proxies);
    if (bake->out) json_object_set_new(facts, "file", json_string(bake->out));
    if (bake->a->model) json_object_set_new(facts, "model", json_string(bake->a->model));
    json_object_set_new(facts, "stopped", json_boolean(r->stopped));
    if (bake->parts.parts > 0) {
        json_object_set_new(facts, "parts", json_integer(bake->parts.parts));
        json_object_set_new(facts, "ranks", json_integer(bake->parts.ranks));
        json_object_set_new(facts, "elements_made_share", json_real(bake->parts.elements_share));
        json_object_set_new(facts, "sent_mb", json_real(bake->parts.sent_mb));
        // Before one starts several.
        if (bake->parts.ranks == 1) {
            json_object_set_new(facts, "sent_mb_of_2", json_real(bake->parts.sent_mb_of_2));
            json_object_set_new(facts, "sent_mb_of_4", json_real(bake->parts.sent_mb_of_4));
        }
        json_object_set_new(facts, "checkpoints", json_integer(bake->parts.kept));
    }
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

// The number of patches in no cell that light reaches all the same. 0 where their light is no more than the light that goes to and
// fro between two faces that touch, such as a wardrobe's back and the wall behind it.
static int lost_in_light(const Bake *bake) {
    static const double BETWEEN = 1e-4;  // share of all emitted light; in homes some millionths of it
    int lost = 0;
    double power = 0;
    for (int p = 0; p < bake->mesh.patch_count; p++) {
        const Patch *patch = &bake->mesh.patches[p];
        double sum = 0;
        if (patch->cell >= 0) continue;
        for (int e = patch->first_element; e < patch->first_element + patch->element_count; e++)
            sum += rgb_sum(bake->solution.radiosity[e]) * bake->mesh.elements[e].area;
        lost += sum > 0;
        power += sum;
    }
    return power > BETWEEN * rgb_sum(bake->solution.emitted) ? lost : 0;
}

static void print_warnings(const Bake *bake) {
    const RadSolution *s = &bake->solution;
    const Mesh *mesh = &bake->mesh;
    app_print_notes(&bake->scene.building, MOST_NOTES);
    double escaped = rgb_sum(s->escaped) / rgb_sum(s->emitted);
    if (escaped > OPEN && !daylight_shines(&s->day))
        fprintf(stderr, "enfilade: %s is open: %.3g %% of its light escaped\n", bake->a->file, 100 * escaped);
    int lost = lost_in_light(bake);
    if (lost > 0)
        fprintf(stderr, "enfilade: %d of %d patches are lit but lie in no cell: nothing is culled for them\n",
                lost, mesh->patch_count);
    if (bake->even)
        fprintf(stderr, "enfilade: %g s are too few for elements that follow the light: all are alike\n",
                bake->a->seconds);
    if (bake->unlit)
        fprintf(stderr,
                "enfilade: after %g s the light straight from lamps was not found anew: shadows are as "
                "coarse as elements\n",
                bake->a->seconds);
    if (bake->report.stopped)
        fprintf(stderr, "enfilade: stopped: this is the light of %lld shots%s\n", (long long)s->shots,
                bake->out ? ", from which --resume goes on" : "");
    if (mesh->dropped_faces > 0)
        fprintf(stderr, "enfilade: %d polygons without area were left out\n", mesh->dropped_faces);
}

// Elements count as constant: slopes would enlarge the errors of elements in corners, where shooters are near.
static void gather_probes(const Bake *bake, Probes *probes) {
    if (probes->count == 0) return;
    GatherScene scene = {&bake->probed->mesh, &bake->scene.forest, bake->doors, &bake->probed_light, NULL};
    bake_probes_gather(&scene, bake->rad.threads, probes);
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

// the exit code
static int bake(BakeArguments *arguments) {
    Bake b = {.a = arguments};
    Arena arena = {0};
    Error error;
    b.start = clock_seconds();
    bool good = compute(&b, &arena, &error);
    b.seconds = clock_seconds() - b.start;
    if (good && team_rank() == 0) print_bake(&b);
    bool stopped = good ? b.report.stopped : app_interrupted();
    arena_free(&arena);
    if (!good) return app_fail(stopped ? APP_STOPPED : APP_BAD_INPUT, "%s", error.text);
    return stopped ? APP_STOPPED : APP_GOOD;
}

typedef struct Arguments {
    BakeArguments to;
    Arena arena;
    bool no_cull;
} Arguments;

// ---- values of their own

static int wrong(Error *error, const char *allowed) {
    error_set(error, "%s", allowed);
    return APP_BAD_USE;
}

static int take_output(const char *path, void *arguments, Error *error) {
    BakeArguments *a = &((Arguments *)arguments)->to;
    static const char *const ENDINGS[] = {"rad", "glb"};
    int ending = options_ending(path, ENDINGS, 2);
    if (ending < 0) return wrong(error, "names that end in .rad or .glb, or have no ending, as a .rad file");
    *(ending == 1 ? &a->model : &a->out) = path;
    return APP_GOOD;
}

static int take_proxies(const char *text, void *arguments, Error *error) {
    char *end;
    double width = strcmp(text, "off") == 0 ? 0 : strtod(text, &end);
    if (width != 0 || strcmp(text, "off") != 0)
        if (end == text || *end || !(width >= 0.001 && width <= 0.1))
            return wrong(error, "0.001 to 0.1, or off");
    ((Arguments *)arguments)->to.bake.mesh.proxy = width;
    return APP_GOOD;
}

static int take_shots(const char *text, void *arguments, Error *error) {
    char *end;
    long shots = strtol(text, &end, 10);
    if (end == text || *end || shots < 1 || shots > INT32_MAX) return wrong(error, "1 to 2147483647");
    ((Arguments *)arguments)->to.bake.rad.shots = shots;
    return APP_GOOD;
}

static int take_method(const char *name, void *arguments, Error *error) {
    RadOptions *rad = &((Arguments *)arguments)->to.bake.rad;
    rad->method = form_factor_method(name);
    return rad->method ? APP_GOOD : wrong(error, "those that --help lists");
}

static int take_hidden(const char *name, void *arguments, Error *error) {
    ((Arguments *)arguments)->to.bake.rad.form_factor.hidden = name;
    return hidden_find(name) ? APP_GOOD : wrong(error, "those that --help lists");
}

static int take_probe(const char *text, void *arguments, Error *error) {
    Arguments *a = arguments;
    Error reason;
    (void)error;
    if (bake_probe_parse(text, &a->arena, &a->to.probes, &reason)) return APP_GOOD;
    return app_misuse("bake", "bake: %s", reason.text);
}

static int take_probes(const char *file, void *arguments, Error *error) {
    Arguments *a = arguments;
    Error reason;
    (void)error;
    a->to.probe_file = file;
    if (bake_probes_read(file, &a->arena, &a->to.probes, &reason)) return APP_GOOD;
    return app_fail(APP_BAD_INPUT, "%s", reason.text);
}

// ---- the table

#define AT(field) offsetof(Arguments, to.field)
static const Option ROWS[] = {
    OPTION_MAP(AT(load.map)),
    OPTION_PHOTOMETRY(AT(load.photometry)),
    {.name = "o",
     .value = "OUT.rad",
     .type = OPTION_OTHER,
     .take = take_output,
     .help = "where to write (default: the user's cache); with OUT.glb, a model for Blender and browsers "
             "with its light in the colours of its vertices; both may be given"},
    {.name = "resume",
     .type = OPTION_FLAG,
     .at = AT(resume),
     .help = "go on from the light that is there, made with the same elements and doors; in parts, from what "
             "was kept of them"},
    {.name = "doors",
     .value = "SPEC",
     .type = OPTION_TEXT,
     .at = AT(bake.doors),
     .help = "where doors stand: parts WHO=STATE with commas between them, or @FILE, a part a line; WHO is a "
             "door's name or `all`, STATE is `drawn`, `open`, `closed`, or a share of the door's way as 0.4 "
             "or 40%; without `=` all are meant (default drawn)"},
    OPTION_DAYLIGHT(AT(load.day), "the default"),
    OPTION_FILL_LAMPS(AT(load.fill_lamps)),
    OPTION_LAMPS(AT(load.lamp_state),
                 "; or `each`: the light of each lamp by itself, so that a walk can switch them"),
    {.name = "element",
     .value = "M",
     .type = OPTION_NUMBER,
     .at = AT(bake.mesh.element),
     .low = 0.01,
     .high = 100,
     .help = "edge of an element aimed at, metres, @ (default: for about 60,000, 0.15 to 0.33)"},
    {.name = "per-patch",
     .value = "K",
     .type = OPTION_INT,
     .at = AT(bake.mesh.per_patch),
     .low = 1,
     .high = 16,
     .help = "elements along the side of a patch, @ (default 2)"},
    {.name = "refine",
     .value = "S",
     .type = OPTION_NUMBER,
     .at = AT(bake.adapt.share),
     .high = 100,
     .help = "elements are small where light changes, large where it is even: S times as many as there would "
             "be if all were alike, @; 0: all are alike (default 0.4)"},
    {.name = "smallest",
     .value = "M",
     .type = OPTION_NUMBER,
     .at = AT(bake.adapt.smallest),
     .low = 0.01,
     .high = 100,
     .help = "edge of the smallest elements, metres, @ (default 0.06)"},
    {.name = "close",
     .value = "M",
     .type = OPTION_NUMBER,
     .at = AT(bake.mesh.close),
     .high = 1,
     .help = "elements are cut along things that stand on a face or this near to it, metres, @; 0: along "
             "none (default 0.05)"},
    {.name = "reach",
     .value = "R",
     .type = OPTION_NUMBER,
     .at = AT(bake.rad.reach),
     .high = 100,
     .help = "elements within so many radii of a patch have light of all of it, not of its centre, @ "
             "(default 2)"},
    {.name = "proxies",
     .value = "M",
     .type = OPTION_OTHER,
     .take = take_proxies,
     .help = "fine furniture is lit by coarse stand-ins whose outlines are within M metres of it, 0.001 to "
             "0.1, or off (default 0.0125)"},
    {.name = "residual",
     .value = "E",
     .type = OPTION_NUMBER,
     .at = AT(bake.rad.residual),
     .low = 1e-9,
     .high = 1,
     .help = "stop when this share of the light, and of each room's, is left to shoot, @ (default 0.0001)"},
    {.name = "shots",
     .value = "N",
     .type = OPTION_OTHER,
     .take = take_shots,
     .help = "stop when so many were shot, those of a run that is resumed included"},
    {.name = "seconds",
     .value = "S",
     .type = OPTION_NUMBER,
     .at = AT(seconds),
     .low = 0.001,
     .high = 1e6,
     .help = "end after about S seconds, @: the mesh takes a quarter of them at most, then elements are all "
             "alike; shooting ends after 0.6 of them; opening the file, and writing, are not cut short"},
    {.name = "final-gather",
     .type = OPTION_FLAG,
     .at = AT(final_gather),
     .help = "then gather the light at every vertex once more, from all that it sees: sharper shadows, for "
             "about half a millisecond each"},
    {.name = "method",
     .value = "NAME",
     .type = OPTION_OTHER,
     .take = take_method,
     .help = "how form factors are found (default hemisphere); below"},
    {.name = "resolution",
     .value = "R",
     .type = OPTION_INT,
     .at = AT(bake.rad.form_factor.resolution),
     .low = 8,
     .high = 2000,
     .help = "pixels, lines or rays across, @ (default 48; with fewer than 10000 patches 80, with "
             "fewer than 4000 200)"},
    {.name = "hidden",
     .value = "NAME",
     .type = OPTION_OTHER,
     .take = take_hidden,
     .help = "how the sides of `hemicube` are filled: one of the hidden-surface methods below (default: its "
             "own)"},
    {.name = "culling",
     .value = "NAME",
     .type = OPTION_NAME,
     .at = AT(bake.rad.culling),
     .names = CULLING_NAMES,
     .name_count = CULLINGS,
     .help = "polygons that are left out: @ (default stab); depth: those behind things; cells, plan "
             "(Oki), stab, portals: also those that the cells exclude; the result is the same"},
    {.name = "no-cull", .type = OPTION_FLAG, .at = offsetof(Arguments, no_cull), .help = "--culling none"},
    {.name = "parts",
     .value = "CELLS",
     .type = OPTION_INT,
     .at = AT(parts),
     .low = 1,
     .high = MAPS_MAX_CELLS,
     .help =
         "in parts of so many cells at most, one after the other or, in a program made by `make mpi=1` and "
         "started by mpirun, side by side: then the default is an eighth of the cells, 16 to 1024. The parts "
         "decide the light, not the number of processes"},
    {.name = "apart",
     .type = OPTION_FLAG,
     .at = AT(apart),
     .help =
         "store the light in parts: OUT.rad names those in the folder OUT.rad.parts; parts that wait lie on "
         "the disk, so --memory needs room for the building and one part; walks and pictures read the part "
         "where the eye is. The default where the whole does not fit"},
    {.name = "checkpoint",
     .value = "S",
     .type = OPTION_NUMBER,
     .at = AT(checkpoint),
     .low = 0.001,
     .high = 1e6,
     .help = "in parts: keep what was found so far every S seconds, @, in the folder OUT.rad.parts, from "
             "where --resume "
             "goes on in any number of processes (default 60)"},
    OPTION_THREADS(AT(bake.rad.threads)),
    OPTION_MEMORY(AT(load.memory), "what fits the file to open it, then three quarters of the machine's"),
    {.name = "row-memory",
     .value = "MB",
     .type = OPTION_MEGABYTES,
     .at = AT(bake.rad.row_bytes),
     .high = 1000000,
     .help = "rows of form factors kept for patches that shoot again, @ (default: 512, and 8 for each 1,000 "
             "elements "
             "beyond 120,000; at most an eighth of the machine's memory, a quarter of --memory)"},
    {.name = "probe",
     .value = "P",
     .type = OPTION_OTHER,
     .take = take_probe,
     .help = "X,Y,Z,NX,NY,NZ: the light at a point, on a line `x y z nx ny nz HR HG HB BR BG BB`: the light "
             "that arrives, W/m^2, and the light that leaves the face on which the point lies; may be given "
             "several times"},
    {.name = "probes",
     .value = "FILE",
     .type = OPTION_OTHER,
     .take = take_probes,
     .help = "as many as there are lines in FILE, or points in a .quads file"},
    OPTION_JSON(AT(json)),
};
static const OptionTable OPTIONS = OPTION_TABLE(
    "bake", "FILE [-o OUT.rad] [-o OUT.glb] [OPTIONS]",
    "Computes the light of a building by radiosity: its polygons are cut into elements, patches of elements "
    "shoot the "
    "light they have, the strongest first, until little is left. Only polygons that the stab tree of a "
    "patch's cell "
    "lets the patch see are looked at. The light is stored in OUT.rad, or in the user's cache. The same "
    "bytes come out on "
    "any number of threads, and with culling or without. Ctrl-C stops early and stores the light so far, "
    "with exit status 3.",
    ROWS);

static int parse_bake(int argc, char **argv, Arguments *a, bool *help) {
    BakeArguments *b = &a->to;
    int code = options_parse_file(&OPTIONS, argc, argv, a, NULL, &b->file, help);
    if (code != APP_GOOD || *help) return code;
    if (a->no_cull) b->bake.rad.culling = CULL_NONE;
    b->load.vis.threads = b->bake.rad.threads;
    if ((code = app_check_day("bake", &b->load.day)) != APP_GOOD) return code;
    b->each = b->load.lamp_state && strcmp(b->load.lamp_state, "each") == 0;
    if (b->each) b->load.lamp_state = NULL;
    bool parts = b->parts > 0 || b->apart || team_is_started();
    if (b->apart && (b->model || b->probes.count > 0))
        return app_misuse("bake", "bake: light that is stored in parts has no OUT.glb and no probes");
    if (!parts && b->checkpoint > 0)
        return app_misuse("bake", "bake: --checkpoint keeps the light of a bake in parts: give --parts");
    if (parts && (b->each || b->final_gather || b->seconds > 0 || b->bake.rad.shots > 0))
        return app_misuse("bake", "bake: light that is found in parts has no --lamps each, --final-gather, "
                                  "--seconds or --shots");
    if (b->each && b->final_gather)
        return app_misuse("bake", "bake: --lamps each: light of each lamp is not gathered by --final-gather");
    if (b->bake.rad.form_factor.hidden && strcmp(b->bake.rad.method->name, "hemicube") != 0)
        return app_misuse("bake", "bake: --hidden fills the sides of a hemicube: give --method hemicube");
    return APP_GOOD;
}

static void print_bake_help(void) {
    options_print_help(&OPTIONS);
    putchar('\n');
    options_print_paragraph(
        "Lights are polygons that emit. A lamp whose model has none gets a square beneath it, or above where "
        "its light sits in its upper half; a light without a lamp becomes a small cube.\n\nform factors:",
        0, 0);
    for (int i = 0; FORM_FACTOR_METHODS[i]; i++)
        printf("  %-24s  %s\n", FORM_FACTOR_METHODS[i]->name, FORM_FACTOR_METHODS[i]->summary);
    printf("\nhidden surfaces:\n");
    for (int i = 0; HIDDEN_METHODS[i]; i++)
        printf("  %-24s  %s\n", HIDDEN_METHODS[i]->name, HIDDEN_METHODS[i]->summary);
}

int cmd_bake(int argc, char **argv) {
    Arguments a = {.to = bake_default_arguments()};
    bool help = false;
    int code = parse_bake(argc, argv, &a, &help);
    if (help) print_bake_help();
    if (code == APP_GOOD && !help) code = bake(&a.to);
    arena_free(&a.arena);
    return code;
}
