// light.c - finds and reads a .rad file for a scene, or makes it.
#include "engine/scene/light.h"

#include <stdio.h>
#include <string.h>

#include "engine/core/clock.h"
#include "engine/scene/bake_mesh.h"
#include "engine/scene/kept_parts.h"
#include "engine/scene/lamp_state.h"
#include "engine/scene/light_parts.h"
#include "radiosity/follow/each_lamp.h"
#include "radiosity/follow/relight.h"
#include "radiosity/mesh/parts.h"
#include "radiosity/shoot/shoot_rows.h"
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
    return (WalkLight){&fine->mesh, shown, doors, fine, NULL, NULL};
}

bool light_shown(const Mesh *mesh, const RadSolution *solution, const float *doors, const Lamps *lamps,
                 Arena *arena, WalkLight *out, Error *error) {
    const Mesh *shown;
    const RadSolution *light;
    if (!shown_light(mesh, solution, doors, arena, &shown, &light, error)) return false;
    *out = show_fine(fine_mesh_new(shown, arena), light, doors, arena);
    if (solution->each) {
        LightStates *states = ARENA_ARRAY(arena, LightStates, 1);
        *states = (LightStates){lamps, mesh, shown, solution};
        out->states = states;
    }
    return true;
}

// Light that was found on one mesh and is shown on another, of such nodes (NULL: they are found), both in a state of the lamps, as it is
// drawn.
static RadSolution draw_fine(const WalkLight *light, const Lamps *lamps, const Mesh *found, const Mesh *shown,
                             const Nodes *nodes, const Rgb *lit, const RadSolution *solution, Arena *arena) {
    RadSolution out = *solution;
    if (shown != found) CORE_ASSERT(shown_fill(found, solution, shown, nodes, arena, &out));
    out.direct = out.unshot = out.rest = NULL;
    FineMesh fine = *light->fine;
    fine.light = shown;
    fine.mesh = lamps_mesh(lamps, &light->fine->mesh, lit, arena);
    return fine_light(&fine, &out, arena);
}

RadSolution light_of_source(const WalkLight *light, int source, Arena *arena) {
    const LightStates *s = light->states;
    Rgb *lit = ARENA_ARRAY(arena, Rgb, s->lamps->count + 1);
    if (source < s->lamps->count) lit[source] = (Rgb){1, 1, 1};
    Mesh found = lamps_mesh(s->lamps, s->found, lit, arena),
         shown = lamps_mesh(s->lamps, s->shown, lit, arena);
    RadSolution one = each_lamp_one(s->solution, source, arena);
    return draw_fine(light, s->lamps, &found, s->shown != s->found ? &shown : &found, NULL, lit, &one, arena);
}

// All that light needs to follow the doors, and the light that is shown.
typedef struct LightFollower {
    Relight relight;
    RadOptions rad;
    Daylight day;  // of the rows
    RadSolution shown;
    const Rgb *lit;  // [count of the lamps] of the light that is shown; NULL: that light is not known
    Rgb *full;       // [count of the lamps]
    Arena kept[2];   // light that was found, each in the one that the light before does not lie in
    int at;
    bool begun;
} LightFollower;

static RadSolution draw_followed(const WalkLight *light, const Rgb *lit, const RadSolution *found,
                                 Arena *arena) {
    const Relight *r = &light->follower->relight;
    const Mesh *shown = direct_sources_shown(r->sources);
    Mesh on = lamps_mesh(r->lamps, r->mesh, lit, arena), by = lamps_mesh(r->lamps, shown, lit, arena);
    return draw_fine(light, r->lamps, &on, shown != r->mesh ? &by : &on, direct_sources_nodes(r->sources),
                     lit, found, arena);
}

bool light_follow_soon(const WalkLight *light, const float *door_open, const Rgb *lit, Arena *arena,
                       RadSolution *out) {
    LightFollower *f = light->follower;
    RadSolution found;
    if (!f->lit || memcmp(lit, f->lit, (size_t)f->relight.lamps->count * sizeof *lit) != 0) return false;
    relight_straight(&f->relight, door_open, lit, &f->shown, arena, &found, NULL);
    *out = draw_followed(light, lit, &found, arena);
    return true;
}

// Into f->shown.
static bool find_followed(LightFollower *f, const float *door_open, const Rgb *lit,
                          const Progress *progress) {
    Arena *room = &f->kept[1 - f->at];
    size_t lamps = (size_t)f->relight.lamps->count;
    RadSolution found;
    f->begun = true;
    arena_reset(room);
    Rgb *own = ARENA_ARRAY(room, Rgb, lamps + 1);
    memcpy(own, lit, lamps * sizeof *own);
    if (!relight_state(&f->relight, door_open, own, progress, room, &found, NULL)) return false;
    f->at = 1 - f->at;
    f->shown = found;
    f->lit = own;
    return true;
}

bool light_follow(const WalkLight *light, const float *door_open, const Rgb *lit, const Progress *progress,
                  Arena *arena, RadSolution *out) {
    if (!find_followed(light->follower, door_open, lit, progress)) return false;
    *out = draw_followed(light, lit, &light->follower->shown, arena);
    return true;
}

bool light_follow_begin(const WalkLight *light, const Progress *progress) {
    LightFollower *f = light->follower;
    if (f->begun) return false;
    f->begun = find_followed(f, light->door_open, f->full, progress);
    return f->begun;
}

bool light_turns(const WalkLight *light) {
    return light->follower && light->follower->rad.sky && light->solution->rest;
}

bool light_turn(const WalkLight *light, const Daylight *day, const float *door_open, const Progress *progress,
                Arena *arena, WalkLight *out) {
    LightFollower *f = light->follower;
    Relight *r = &f->relight;
    size_t openings = (size_t)r->mesh->graph->building->opening_count;
    RadSolution *found = ARENA_ARRAY(arena, RadSolution, 1), filled;
    if (!relight_turn(r, day, door_open, progress, arena, found)) return false;
    for (int i = 0; i < 2; i++) arena_free(&f->kept[i]);
    f->begun = false;
    f->lit = f->full;
    f->shown = filled = *found;
    float *doors = ARENA_ARRAY(arena, float, openings + 1);
    memcpy(doors, door_open, openings * sizeof *doors);
    Mesh *shown = ARENA_ARRAY(arena, Mesh, 1);
    *shown = mesh_copy(direct_sources_shown(r->sources), arena);
    if (direct_sources_shown(r->sources) != r->mesh)
        CORE_ASSERT(shown_fill(r->mesh, found, shown, direct_sources_nodes(r->sources), arena, &filled));
    *out = show_fine(fine_mesh_new(shown, arena), &filled, doors, arena);
    out->follower = f;
    return true;
}

void light_follow_sum(const WalkLight *light, const Rgb *lit) {
    LightFollower *f = light->follower;
    bool full = memcmp(lit, f->full, (size_t)f->relight.lamps->count * sizeof *lit) == 0;
    f->lit = full ? f->full : NULL;
    if (full) f->shown = *f->relight.all;
}

const Lamps *light_follower_lamps(const WalkLight *light) { return light->follower->relight.lamps; }

void light_end(WalkLight *light) {
    if (!light->follower) return;
    relight_end(&light->follower->relight);
    shoot_rows_end(light->follower->rad.rows);
    if (light->follower->rad.sky) sky_looks_end(light->follower->rad.sky);
    direct_sources_end(light->follower->relight.sources);
    for (int i = 0; i < 2; i++) arena_free(&light->follower->kept[i]);
    light->follower = NULL;
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

static bool same_state(Rgb a, Rgb b) { return a.r == b.r && a.g == b.g && a.b == b.b; }

bool light_take_lamps(const char *file, const LoadedScene *scene, RadSolution *solution, Error *error) {
    static const Rgb FULL = {1, 1, 1};
    const Lamps *lamps = &scene->lamps;
    if (solution->lamp_count > 0 && solution->lamp_count != lamps->count)
        return error_set(error, "%s: knows %d lamps (the building has %d)", file, solution->lamp_count,
                         lamps->count);
    for (int i = 0; i < lamps->count; i++) {
        Rgb had = solution->lit ? solution->lit[i] : FULL;
        if (same_state(had, scene->lit[i])) continue;
        if (!solution->each) {
            char made[32], asked[32];
            lamp_state_describe(lamps, i, had, made, sizeof made);
            lamp_state_describe(lamps, i, scene->lit[i], asked, sizeof asked);
            return error_set(
                error,
                "%s: was made with lamp %d, %.100s, %s (asked for: %s; `bake --lamps each` makes light "
                "of all states)",
                file, i + 1, lamps->lamps[i].name, made, asked);
        }
        each_lamp_sum(solution, scene->lit);
        break;
    }
    solution->lit = scene->lit;
    solution->lamp_count = lamps->count;
    return true;
}

// `part` NULL: of the whole building. `proxies`: as proxies_find gives them, NULL: they are found.
static bool load_light(const char *path, const LoadedScene *scene, const MeshPart *part,
                       const Proxies *proxies, Arena *arena, WalkLight *out, Error *error) {
    const CellGraph *graph = &scene->graph;
    MeshOptions options;
    float *doors = ARENA_ARRAY(arena, float, scene->building.opening_count + 1);
    Mesh *mesh = ARENA_ARRAY(arena, Mesh, 1);
    RadSolution *solution = ARENA_ARRAY(arena, RadSolution, 1);
    bool good = rad_load_options(path, &scene->building, arena, &options, doors, error);
    if (good) {
        options.part = part;
        options.proxies = proxies ? proxies : proxies_find(graph, options.proxy, arena);
        good = mesh_build(graph, doors, &options, arena, mesh, error) &&
               rad_load(path, mesh, doors, arena, solution, error) &&
               (!scene->day_given || light_check_day(path, solution, &scene->day, error)) &&
               light_take_lamps(path, scene, solution, error);
        if (good) *mesh = scene_lit_mesh(scene, mesh, arena);
    }
    if (!good) return false;
    if (light_shown(mesh, solution, doors, &scene->lamps, arena, out, error)) return true;
    Error reason = *error;
    return error_set(error, "%s: %.900s", path, reason.text);
}

bool light_load(const char *path, const LoadedScene *scene, Arena *arena, WalkLight *out, Error *error) {
    if (light_parts_is(path))
        return error_set(error, "%s: is light in parts, which only walks and pictures show", path);
    return load_light(path, scene, NULL, NULL, arena, out, error);
}

// ---- light in parts

struct LightOfParts {
    const char *path, *folder;
    const LoadedScene *scene;
    LightParts stored;
    Parts parts;
    const Proxies *proxies;
};

bool light_find_parts(const LoadedScene *scene, Arena *arena, const LightOfParts **out, Error *error) {
    *out = NULL;
    if (scene->light_count == 0 || !light_parts_is(scene->lights[0])) return true;
    LightOfParts *p = ARENA_ARRAY(arena, LightOfParts, 1);
    MeshOptions options;
    *p = (LightOfParts){
        .path = scene->lights[0], .folder = kept_folder(scene->lights[0], arena), .scene = scene};
    if (!light_parts_load(p->path, &scene->building, &p->stored, error)) return false;
    p->parts = parts_of(&scene->graph, &scene->forest, p->stored.cells, arena);
    if (p->parts.count != p->stored.parts)
        return error_set(error, "%s: has %d parts of %d cells (this program makes %d of them)", p->path,
                         p->stored.parts, p->stored.cells, p->parts.count);
    Arena scratch = {0};
    float *doors = ARENA_ARRAY(&scratch, float, scene->building.opening_count + 1);
    bool good =
        rad_load_options(light_parts_file(p, 0, arena), &scene->building, &scratch, &options, doors, error);
    if (good) p->proxies = proxies_find(&scene->graph, options.proxy, arena);
    arena_free(&scratch);
    if (good) *out = p;
    return good;
}

int light_parts_number(const LightOfParts *p) { return p->parts.count; }
const LoadedScene *light_parts_scene(const LightOfParts *p) { return p->scene; }
double light_parts_level(const LightOfParts *p) { return p->stored.level; }

const char *light_parts_file(const LightOfParts *p, int part, Arena *arena) {
    return kept_file(p->folder, p->stored.set, part, p->stored.parts, arena);
}

int light_part_of(const LightOfParts *p, int cell) { return cell < 0 ? -1 : p->parts.cell_owner[cell]; }

bool light_load_part(const LightOfParts *p, int part, Arena *arena, WalkLight *out, Error *error) {
    const char *path = light_parts_file(p, part, arena);
    Arena scratch = {0};
    MeshOptions options;
    float *doors = ARENA_ARRAY(&scratch, float, p->scene->building.opening_count + 1);
    bool good = rad_load_options(path, &p->scene->building, &scratch, &options, doors, error);
    arena_free(&scratch);
    if (!good) return false;
    MeshPart *of = ARENA_ARRAY(arena, MeshPart, 1);
    *of = part_of(&p->parts, &p->scene->forest, part, options.close, arena);
    return load_light(path, p->scene, of, p->proxies, arena, out, error);
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

// A bake under way.
typedef struct Baking {
    const SceneBake *bake;
    const LightHooks *hooks;
    BakeOptions options;
    Mesh *mesh;
    RadSolution *solution;
    float *doors;
    Arena *arena;
    // Where light is to follow, else NULL.
    DirectSources *sources;
    const Mesh *drawn;  // the mesh and its doors, or copies of them that stay as they were baked
    float *drawn_doors;
} Baking;

static bool store(const Baking *b, Error *error) {
    *error = (Error){""};
    return !b->bake->out || rad_save(b->bake->out, b->mesh, b->doors, b->solution, error);
}

// Shoots all light and shows it.
static bool bake_all(Baking *b, WalkLight *out, Error *error) {
    const StabForest *forest = &b->bake->scene->forest;
    const LightHooks *hooks = b->hooks;
    Shower shower = {.hooks = hooks, .fine = fine_mesh_new(b->mesh, b->arena)};
    if (hooks->show) {
        show_solution(&shower, b->solution);
        b->options.rad.show = show_solution;
        b->options.rad.show_due = show_is_due;
        b->options.rad.show_context = &shower;
    }
    RadReport report = rad_shoot(b->mesh, forest, b->doors, &b->options.rad, &hooks->progress, b->solution);
    if (report.stopped) return error_set(error, "stopped");
    if (hooks->show) show_solution(&shower, b->solution);
    if (!direct_show_apart(b->mesh, forest, b->doors, hooks->threads, &hooks->progress, b->arena, b->solution,
                           b->sources, NULL, NULL) ||
        !light_shown(b->drawn, b->solution, b->drawn_doors, &b->bake->scene->lamps, b->arena, out, error))
        return error_set(error, "stopped");
    return true;
}

// Light of each lamp, where all light is there: `out` stays as it is where there is none.
static void bake_each(Baking *b, WalkLight *out, Error *error) {
    const LoadedScene *scene = b->bake->scene;
    EachLamp each = {b->mesh, &scene->lamps, &scene->forest, b->doors, &b->options.rad, b->sources};
    WalkLight light;
    if (!b->solution->gathered || !b->solution->node ||
        !each_lamp_find(&each, &b->hooks->progress, b->arena, b->solution))
        return;
    if (light_shown(b->drawn, b->solution, b->drawn_doors, &scene->lamps, b->arena, &light, error))
        *out = light;
    store(b, error);
}

static bool has_doors(const Building *b) {
    for (int i = 0; i < b->opening_count; i++)
        if (b->openings[i].kind == OPENING_DOOR) return true;
    return false;
}

// Keeps what is needed to light the building with its doors elsewhere. Rows and sources share the doors that will move.
static void begin_following(Baking *b, LightFollower *follower) {
    const LoadedScene *scene = b->bake->scene;
    Mesh *drawn = ARENA_ARRAY(b->arena, Mesh, 1);
    int openings = scene->building.opening_count;
    b->drawn_doors = ARENA_ARRAY(b->arena, float, openings + 1);
    memcpy(b->drawn_doors, b->doors, (size_t)openings * sizeof *b->doors);
    *drawn = mesh_copy(b->mesh, b->arena);
    b->drawn = drawn;
    follower->full = ARENA_ARRAY(b->arena, Rgb, scene->lamps.count + 1);
    for (int i = 0; i < scene->lamps.count; i++) follower->full[i] = (Rgb){1, 1, 1};
    b->sources = each_lamp_sources(b->mesh, &scene->lamps, b->hooks->threads, b->arena);
    relight_prepare(b->sources, b->mesh, b->arena);
    follower->rad = b->options.rad;
    follower->day = b->options.day;
    if (daylight_shines(&follower->day)) {
        follower->rad.form_factor.sky_parts = true;
        follower->rad.sky = sky_looks_new(b->mesh, &scene->forest, b->doors, &follower->rad);
        direct_sources_turn(b->sources, NULL, NULL);
    }
    follower->rad.rows =
        shoot_rows_new(b->mesh, &scene->forest, b->doors, &follower->rad, &follower->day, b->arena);
    b->options.rad = follower->rad;
    follower->relight = (Relight){.mesh = b->mesh,
                                  .lamps = &scene->lamps,
                                  .forest = &scene->forest,
                                  .door_open = b->doors,
                                  .options = &follower->rad,
                                  .sources = b->sources,
                                  .all = b->solution,
                                  .day = &follower->day};
}

static bool bake_scene(void *context, const LightHooks *hooks, Arena *arena, WalkLight *out, Error *error) {
    const SceneBake *bake = context;
    const LoadedScene *scene = bake->scene;
    Baking b = {.bake = bake,
                .hooks = hooks,
                .options = bake_default_options(),
                .mesh = ARENA_ARRAY(arena, Mesh, 1),
                .solution = ARENA_ARRAY(arena, RadSolution, 1),
                .arena = arena};
    b.options.rad.threads = hooks->threads;
    b.options.day = scene->day;
    if (!bake_mesh(&b.options, scene, NULL, &hooks->progress, arena, &b.doors, b.mesh, error) ||
        !progress_report(&hooks->progress, "mesh", 0))
        return false;
    LightFollower *follower = NULL;
    bool follows = (hooks->follow || hooks->each) && has_doors(&scene->building);
    if (follows || (hooks->each && scene->lamps.count > 0)) follower = ARENA_ARRAY(arena, LightFollower, 1);
    if (!follower) *b.mesh = scene_lit_mesh(scene, b.mesh, arena);
    b.drawn = b.mesh;
    b.drawn_doors = b.doors;
    rad_fit(b.mesh, &b.options.rad);
    if (follower) begin_following(&b, follower);
    bool good =
        begin_light(&b.options, &scene->forest, b.doors, &hooks->progress, b.mesh, arena, b.solution, error);
    if (good && !follower) b.solution->lit = scene->lit;
    if (good && !follower) b.solution->lamp_count = scene->lamps.count;
    good = good && bake_all(&b, out, error);
    if (good) store(&b, error);
    bool kept = good && follows && b.solution->gathered && b.solution->rest;
    if (kept) out->follower = follower;
    if (good && hooks->whole) hooks->whole(hooks->context, out);
    if (good && hooks->each && scene->lamps.count > 0) bake_each(&b, out, error);
    out->follower = follower;
    if (kept)
        light_follow_sum(out, follower->full);
    else
        light_end(out);
    return good;
}

LightBaker light_baker(LoadedScene *scene, bool keep, Arena *arena) {
    Error error;
    bool lit = scene_emits(scene) || daylight_shines(&scene->day);
    if (!lit || !scene_has_walls(scene, &error)) return (LightBaker){0};
    SceneBake *bake = ARENA_ARRAY(arena, SceneBake, 1);
    *bake = (SceneBake){scene, keep ? light_place(&scene->building, arena) : NULL};
    if (keep && !scene_cache_takes(scene, bake->out, LIGHT_ROOM)) bake->out = NULL;
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
    return (LightBaker){read_or_bake, stored, .anew = otherwise.bake ? &stored->otherwise : NULL,
                        .stored = true, .asked = asked};
}

// ---- loading a building to walk through

bool walk_scene_load(void *context, const char *path, Arena *arena, WalkScene *out, Error *error) {
    SceneOptions *load = context;
    LoadedScene *scene = ARENA_ARRAY(arena, LoadedScene, 1);
    if (!scene_load(path, load, arena, scene, error) || !scene_has_walls(scene, error)) return false;
    *out = (WalkScene){.scene = scene, .graph = &scene->graph, .forest = &scene->forest};
    const LightOfParts *parts;
    bool later = load->light_later && scene->light_count > 0;
    if (!light_find_parts(scene, arena, &parts, error)) return false;
    if (parts) {
        out->baker = (LightBaker){.stored = true, .asked = load->light != NULL, .parts = parts};
        load->gentle = true;
        return true;
    }
    if (!later && !light_find(scene, load->light != NULL, arena, &out->light, error)) return false;
    if (!out->light && load->lamps == SCENE_LAMPS_ALL) out->baker = light_baker(scene, !load->turned, arena);
    if (later) out->baker = stored_light(scene, load->light != NULL, out->baker, arena);
    load->gentle = true;
    return true;
}

// The weather of a day whose light was stored goes on.
static int weather_of(const Daylight *day) {
    for (int w = 0; w < DAYLIGHT_WEATHERS && daylight_shines(day); w++)
        if (strcmp(daylight_weather_name(day), DAYLIGHT_WEATHER_NAMES[w]) == 0) return w;
    return -1;
}

bool walk_scene_turn(void *context, const WalkScene *shown, int minutes, char *said, size_t size,
                     Daylight *day, Error *error) {
    SceneOptions *load = context;
    const LoadedScene *scene = shown->scene;
    const Building *building = &scene->building;
    if (load->lamps != SCENE_LAMPS_ALL)
        return error_set(error, "the hour stays as it is: this walk bakes no light (--no-bake)");
    if (daylight_shines(&scene->day) && daylight_is_uniform(&scene->day))
        return error_set(error, "the hour stays as it is: an even sky (--sky) has none");
    DayOptions *from = &load->turned_from;
    if (isnan(from->time[0])) {
        *from = day_at_hour(&load->day, building, day_hour(&load->day, building, &scene->day));
        if (from->weather < 0) from->weather = weather_of(&scene->day);
    }
    load->turned = minutes;
    double hour = from->time[0] + minutes / 60.0;
    int of_day = (int)(lrint(60 * hour) % (24 * 60) + 24 * 60) % (24 * 60);
    DayOptions at = day_at_hour(from, building, hour);
    bool night = minutes ? at.night : !daylight_shines(&scene->day);
    *day = (Daylight){0};
    if (!night && !day_over(&at, building, day, error)) return false;
    snprintf(said, size, "%02d:%02d%s", of_day / 60, of_day % 60, night ? ", night" : "");
    return true;
}
