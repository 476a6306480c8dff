// bake_parts.c - each member of the team makes the mesh of its part and finds the light there; the first one joins all light.
#include "engine/scene/bake_parts.h"

#include <string.h>
#include <unistd.h>

#include "engine/core/clock.h"
#include "engine/core/file.h"
#include "engine/core/memory.h"
#include "engine/scene/door_state.h"
#include "engine/scene/kept_parts.h"
#include "engine/scene/light.h"
#include "engine/scene/light_level.h"
#include "engine/scene/light_parts.h"
#include "radiosity/mesh/parts.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/direct.h"
#include "radiosity/show/joined.h"

typedef struct PartsBake {
    BakeOptions options;  // with what all parts share
    const LoadedScene *scene;
    const PartsKeep *keep;
    const Progress *progress;
    int cells;
    Parts parts;
    const double *weight;  // [parts], NULL in a process alone
    PartsReport *report;
    Arena *arena;             // of what the first member keeps
    const TeamBytes *letter;  // [parts] to the first member
    bool good;
    Error error;
} PartsBake;

int bake_parts_cells(const CellGraph *graph) {
    int cells = (graph->cell_count + PARTS_FITTING - 1) / PARTS_FITTING;
    return cells < PARTS_LEAST_CELLS  ? PARTS_LEAST_CELLS
           : cells > PARTS_MOST_CELLS ? PARTS_MOST_CELLS
                                      : cells;
}

// Memory of a part for each of its cells, bytes: 1.6 MB where parts have 420 cells of a generated campus, with all that is seen from them.
static const size_t CELL_BYTES = (size_t)2 << 20;
// Rows of light that stays apart take this part of the memory.
enum { ROWS_APART = 32 };

// The least of all processes, in `cells`.
static void agree_cells(void *cells, TeamMember *member) {
    double most = -*(const int *)cells;
    team_most(member, &most, 1);
    *(int *)cells = (int)-most;
}

int bake_parts_cells_apart(void) {
    size_t fit = memory_left() / 2 / CELL_BYTES;
    int cells = fit < PARTS_LEAST_CELLS  ? PARTS_LEAST_CELLS
                : fit > PARTS_MOST_CELLS ? PARTS_MOST_CELLS
                                         : (int)fit;
    Error error;
    // A process that cannot start a thread for this could not start those of its parts either, which is told then.
    if (team_ranks() > 1) team_run(team_ranks(), NULL, agree_cells, &cells, NULL, &error);
    return cells;
}

bool bake_parts_are_needed(const BakeOptions *options, const LoadedScene *scene) {
    return !memory_fits(bake_least_bytes(options, &scene->graph));
}

// Did all members do it? Else all keep the first sentence of one that did not; who only heard of it says `stopped`.
static bool agree(TeamMember *member, bool good, const Error *error, Error *first) {
    Arena scratch = {0};
    const char *own = good ? "" : error->text, *sentence = NULL;
    const TeamBytes *said = team_collect(member, own, strlen(own) + 1, &scratch);
    for (int m = 0; m < team_count(member); m++) {
        const char *text = said[m].data;
        if (*text && (!sentence || strcmp(sentence, "stopped") == 0)) sentence = text;
    }
    if (sentence) error_set(first, "%s", sentence);
    arena_free(&scratch);
    return !sentence;
}

static bool all_did(PartsBake *b, TeamMember *member, bool good, const Error *error) {
    return b->good = agree(member, good, error, &b->error);
}

// ---- light is kept

// A member that keeps the light of its part.
typedef struct Keeper {
    PartsBake *bake;
    TeamMember *member;
    const Mesh *mesh;
    const float *doors;
    int from, set;  // the set that light goes on from, 0: none; and the next one
    int kept;       // the last whole set
    int spared;     // the set of earlier light that stays until the new one is whole, 0: none
    double due;     // on the clock
    bool off;
} Keeper;

// Where light is stopped, as the user is told.
static Error stopped(const Keeper *k) {
    Error error = {"stopped"};
    if (k->kept > 0)
        error_set(&error, "stopped: what was found is kept in %s, from where --resume goes on",
                  k->bake->keep->folder);
    return error;
}

static void prepare_last_words(const Keeper *k) {
    Error reason = stopped(k), sentence;
    error_set(&sentence, "enfilade: %.900s\n", reason.text);
    team_last_words(sentence.text);
}

// The first member looks what there is.
static bool begin_keeping(PartsBake *b, TeamMember *member, Keeper *out) {
    const PartsKeep *keep = b->keep;
    Error error = {""};
    bool first = team_index(member) == 0, good = true;
    int from = 0;
    *out = (Keeper){.bake = b, .member = member, .off = !keep};
    if (!keep) return true;
    LightParts before = {0};
    if (first && keep->apart && light_parts_is(keep->apart))
        light_parts_load(keep->apart, &b->scene->building, &before, &error);
    out->spared = before.set;
    if (first && keep->resume) good = kept_find(keep->folder, b->parts.count, &from, &error);
    if (good && from > 0 && from == before.set)
        good = error_set(&error, "%s: its light is whole: there is nothing to go on from", keep->apart);
    double sets[2] = {from, first ? kept_last(keep->folder) + 1 : 0};
    team_most(member, sets, 2);
    out->from = out->kept = (int)sets[0];
    out->set = (int)sets[1];
    out->due = clock_seconds() + keep->seconds;
    prepare_last_words(out);
    return all_did(b, member, good, &error);
}

static bool keeping_is_due(void *context) {
    const Keeper *k = context;
    return !k->off && team_index(k->member) == 0 && clock_seconds() >= k->due;
}

// Between two sets at least this many times the time passes that one takes.
static const double TIMES_KEPT = 10;

// Earlier sets go once this one is whole. What cannot be kept any more ends no bake.
static void keep_light(void *context, const RadSolution *so_far) {
    Keeper *k = context;
    PartsBake *b = k->bake;
    Arena scratch = {0};
    Error error = {""};
    int own = team_index(k->member);
    double began = clock_seconds();
    if (k->off) return;
    const char *path = kept_file(b->keep->folder, k->set, own, b->parts.count, &scratch);
    bool good =
        file_make_folder(b->keep->folder, &error) && rad_save(path, k->mesh, k->doors, so_far, &error);
    good = agree(k->member, good, &error, &b->report->unkept);
    if (good && own == 0) kept_remove(b->keep->folder, k->set, k->spared);
    if (good) {
        k->kept = k->set;
        prepare_last_words(k);
    }
    b->report->kept += good && own == 0;
    k->off = !good;
    k->set++;
    // Large buildings do not spend their time with this.
    double now = clock_seconds();
    k->due = now + fmax(b->keep->seconds, TIMES_KEPT * (now - began));
    arena_free(&scratch);
}

// The work of all members.
static RadReport add_work(TeamMember *member, RadReport r) {
    double sums[] = {(double)r.rows_made,
                     (double)r.rows_kept,
                     (double)r.row_bytes,
                     (double)r.direct_points,
                     (double)r.direct_pairs,
                     (double)r.direct_cut,
                     r.seconds_visibility,
                     r.faces_drawn_mean * (double)r.rows_made,
                     r.elements_drawn_mean * (double)r.rows_made};
    team_sum(member, sums, sizeof sums / sizeof *sums);
    r.rows_made = (long long)sums[0];
    r.rows_kept = (long long)sums[1];
    r.row_bytes = (size_t)sums[2];
    r.direct_points = (long long)sums[3];
    r.direct_pairs = (long long)sums[4];
    r.direct_cut = (long long)sums[5];
    r.seconds_visibility = sums[6];
    r.faces_drawn_mean = sums[7] / fmax(sums[0], 1);
    r.elements_drawn_mean = sums[8] / fmax(sums[0], 1);
    return r;
}

// As fits the mesh of the whole; rows have their part of the memory.
static RadOptions fit(const PartsBake *b, TeamMember *member, const Mesh *mesh) {
    RadOptions rad = b->options.rad;
    Mesh whole = *mesh;
    double counts[2] = {0, 0};
    for (int p = 0; p < mesh->patch_count; p++) {
        bool own = mesh_owns(mesh, mesh->patches[p].face);
        counts[0] += own;
        counts[1] += own ? mesh->patches[p].element_count : 0;
    }
    team_sum(member, counts, 2);
    whole.patch_count = (int)counts[0];
    whole.element_count = (int)counts[1];
    rad_fit(&whole, &rad);
    // Where members sleep, one has rows at a time.
    if (!b->keep || !b->keep->apart)
        rad.row_bytes /= (size_t)((b->parts.count + team_ranks() - 1) / team_ranks());
    double all = mesh->element_count;
    team_sum(member, &all, 1);
    b->report->elements_share = all / fmax(counts[1], 1);
    return rad;
}

static bool shine(PartsBake *b, TeamMember *member, const Mesh *mesh, const float *doors,
                  const RadOptions *rad, const Progress *progress, Arena *arena, RadSolution *out) {
    Error error = {"stopped"};
    double emitted = 0;
    bool good = all_did(b, member, rad_start_dark(mesh, arena, out, &error), &error);
    if (good && daylight_shines(&b->scene->day))
        good = all_did(b, member,
                       rad_shine(mesh, &b->scene->forest, doors, rad, &b->scene->day, progress, out), &error);
    if (!good) return false;
    emitted = rgb_sum(out->emitted);
    team_sum(member, &emitted, 1);
    if (!(emitted > 0)) error_set(&error, "nothing emits light, and no daylight comes in");
    return all_did(b, member, emitted > 0, &error);
}

// The light of a part that was kept.
static bool take_kept(PartsBake *b, const char *path, TeamMember *member, const Mesh *mesh,
                      const float *doors, Arena *arena, RadSolution *out) {
    Error error = {""};
    bool good = rad_load(path, mesh, doors, arena, out, &error) &&
                light_check_day(path, out, &b->scene->day, &error) &&
                light_take_lamps(path, b->scene, out, &error);
    return all_did(b, member, good, &error);
}

// The first member gets the light of all.
static void join(PartsBake *b, TeamMember *member, const Mesh *mesh, const RadSolution *solution,
                 const float *doors, Arena *arena) {
    Error error = {""};
    bool first = team_index(member) == 0;
    TeamBytes *to = ARENA_ARRAY(arena, TeamBytes, team_count(member));
    if (!all_did(b, member, joined_pack(mesh, solution, doors, arena, &to[0], &error), &error)) return;
    const TeamBytes *from = team_exchange(member, to, first ? b->arena : arena);
    if (first) b->letter = from;
}

// ---- light that stays apart

// The sums of all parts, of their own faces alone. Returns the level of the light.
static double count_light(PartsBake *b, TeamMember *member, const Mesh *mesh, const RadSolution *solution) {
    double sums[5] = {0};
    for (int f = 0; f < mesh->face_count; f++) {
        if (!mesh_owns(mesh, f)) continue;
        sums[0]++;
        sums[1] += mesh->faces[f].patch_count;
        sums[2] += mesh->faces[f].element_count;
        Rgb e = mesh_material(mesh, f)->emission;
        for (int p = 0; p < mesh->faces[f].patch_count; p++)
            sums[4] += ((double)e.r + (double)e.g + (double)e.b) *
                       mesh->patches[mesh->faces[f].first_patch + p].area;
    }
    sums[3] = solution->node_count;
    team_sum(member, sums, 5);
    b->report->polygons = sums[0];
    b->report->patches = sums[1];
    b->report->elements = sums[2];
    b->report->nodes = sums[3];
    b->report->lamp_watts = sums[4];
    if (team_index(member) == 0) b->report->power = *solution;
    LightLevel level = {0};
    light_level_add(&level, mesh, solution);
    team_sum(member, level.weight, 2);
    team_sum(member, level.log, 2);
    return light_level(&level);
}

// As it is drawn, which takes about so many bytes for each element. Where there is no room for this, a walk makes it.
enum { DRAWN_BYTES = 1000 };
static bool store_drawn(const PartsBake *b, const char *rad, const Mesh *mesh, const float *doors,
                        const RadSolution *light, Arena *arena, Error *error) {
    WalkLight shown;
    size_t elements = (size_t)fmax(mesh->element_count, light->node_count);
    if (!b->keep->drawn || !memory_fits(DRAWN_BYTES * elements)) return true;
    return light_shown(mesh, light, doors, &b->scene->lamps, arena, &shown, error) &&
           b->keep->drawn(b->scene, rad, &shown, error);
}

// Each part gets the light of all that it sees, and stores it. What the light was found on goes before: `found`.
static bool store_apart(PartsBake *b, Keeper *keeper, Borders *borders, const Mesh *mesh,
                        const RadSolution *solution, Arena *found) {
    const LoadedScene *scene = b->scene;
    TeamMember *member = keeper->member;
    int own = team_index(member), parts = team_count(member), openings = scene->building.opening_count;
    Arena arena = {0}, letters = {0};
    Error error = {""};
    Mesh unlit;
    RadSolution light;
    TeamBytes *to = ARENA_ARRAY(&letters, TeamBytes, parts);
    float *doors = ARENA_ARRAY(&arena, float, openings + 1);
    memcpy(doors, keeper->doors, (size_t)openings * sizeof *doors);
    double level = count_light(b, member, mesh, solution);
    bool good = joined_pack_each(mesh, solution, doors, borders, &letters, to, &error);
    // It goes before letters are carried: all parts together have several times what is written.
    arena_free(found);
    good = all_did(b, member, good, &error);
    const TeamBytes *from = good ? team_exchange(member, to, &arena) : NULL;
    arena_free(&letters);
    if (!good) {
        arena_free(&arena);
        return false;
    }
    MeshOptions options = b->options.mesh;
    MeshPart part = part_of(&b->parts, &scene->forest, own, options.close, &arena);
    options.part = &part;
    good = joined_light(&scene->graph, &options, doors, from, parts, &arena, &unlit, &light, &error);
    if (good) {
        Mesh lit = scene_lit_mesh(scene, &unlit, &arena);
        light.lit = scene->lit;
        light.lamp_count = scene->lamps.count;
        const char *path = kept_file(b->keep->folder, keeper->set, own, parts, &arena);
        good = file_make_folder(b->keep->folder, &error) && rad_save(path, &lit, doors, &light, &error) &&
               store_drawn(b, path, &lit, doors, &light, &arena, &error);
    }
    // Before they meet again: that of all parts together would be the most that ever waits.
    arena_free(&arena);
    good = all_did(b, member, good, &error);
    LightParts all = {b->cells, parts, keeper->set, level, scene->day};
    if (good && own == 0) good = light_parts_save(b->keep->apart, &scene->building, &all, &error);
    good = all_did(b, member, good, &error);
    if (good && own == 0) kept_remove(b->keep->folder, keeper->set, 0);
    return good;
}

static void bake_part(void *context, TeamMember *member) {
    PartsBake *b = context;
    const LoadedScene *scene = b->scene;
    Arena arena = {0};
    Error error = {"stopped"};
    Mesh mesh;
    Keeper keeper;
    const char *kept = NULL;
    float *doors;
    RadSolution solution;
    RadReport report = {0};
    bool first = team_index(member) == 0;
    // One member tells the user; when it stops, all do.
    const Progress *progress = first ? b->progress : NULL;
    BakeOptions options = b->options;
    MeshPart part = part_of(&b->parts, &scene->forest, team_index(member), options.mesh.close, &arena);
    options.member = member;
    options.mesh.part = &part;
    bool good = begin_keeping(b, member, &keeper);
    if (keeper.from > 0)
        kept = kept_file(b->keep->folder, keeper.from, team_index(member), b->parts.count, &arena);
    if (good) {
        good = bake_mesh(&options, scene, kept, progress, &arena, &doors, &mesh, &error);
        good = all_did(b, member, good, &error);
    }
    if (good) {
        Mesh lit = scene_lit_mesh(scene, &mesh, &arena);
        RadOptions rad = fit(b, member, &lit);
        Borders *borders = borders_new(&lit, member, &arena, &error);
        rad.borders = borders;
        good = all_did(b, member, borders != NULL, &error) &&
               (kept ? take_kept(b, kept, member, &lit, doors, &arena, &solution)
                     : shine(b, member, &lit, doors, &rad, progress, &arena, &solution));
        if (good) {
            solution.lit = scene->lit;
            solution.lamp_count = scene->lamps.count;
            keeper.mesh = &lit;
            keeper.doors = doors;
            if (b->keep) rad.show = keep_light;
            rad.show_due = keeping_is_due;
            rad.show_context = &keeper;
            report = rad_shoot(&lit, &scene->forest, doors, &rad, progress, &solution);
            error = stopped(&keeper);
            good = all_did(b, member, !report.stopped, &error);
        }
        if (good) {
            bool shown = direct_show_apart(&lit, &scene->forest, doors, rad.threads, progress, &arena,
                                           &solution, NULL, borders, &report);
            good = all_did(b, member, shown, &error);
        }
        if (good) b->report->rad = add_work(member, report);
        if (good && b->keep && b->keep->apart)
            store_apart(b, &keeper, borders, &lit, &solution, &arena);
        else if (good)
            join(b, member, &lit, &solution, doors, &arena);
    }
    b->report->sent_mb = (double)team_sent(member) / 1e6;
    if (team_ranks() == 1) {
        b->report->sent_mb_of_2 = (double)team_would_send(member, 2) / 1e6;
        b->report->sent_mb_of_4 = (double)team_would_send(member, 4) / 1e6;
    }
    arena_free(&arena);
}

// A folder goes if it is empty.
static void leave_folder(void *path) { rmdir(path); }

// A part has as much to do as it sees objects: of ten parts of a campus each took 3.1 to 3.7 ms for one of them.
static const double *part_weights(const PartsBake *b, Arena *arena) {
    const LoadedScene *scene = b->scene;
    int words = (scene->graph.object_count + 63) / 64;
    double *weight = ARENA_ARRAY(arena, double, b->parts.count);
    for (int p = 0; p < b->parts.count; p++) {
        Arena scratch = {0};
        MeshPart part = part_of(&b->parts, &scene->forest, p, b->options.mesh.close, &scratch);
        weight[p] = 1;
        for (int w = 0; w < words; w++) weight[p] += __builtin_popcountll(part.seen[w]);
        arena_free(&scratch);
    }
    return weight;
}

static bool run_apart(PartsBake *b, Error *error) {
    Arena scratch = {0};
    char *folder = arena_string(&scratch, b->keep->folder);
    MemoryEnd end = {leave_folder, folder, NULL};
    bool good = file_make_folder(folder, error);
    memory_add_end(&end);
    good = good && team_run(b->parts.count, b->weight, bake_part, b, folder, error);
    memory_remove_end(&end);
    leave_folder(folder);
    arena_free(&scratch);
    return good;
}

bool bake_parts(const BakeOptions *options, const LoadedScene *scene, int cells, const PartsKeep *keep,
                const Progress *progress, Arena *arena, float **doors, Mesh *mesh, RadSolution *out,
                PartsReport *report, Error *error) {
    Arena own = {0};
    bool apart = keep && keep->apart;
    const CellGraph *graph = &scene->graph;
    *report = (PartsReport){.ranks = team_ranks()};
    PartsBake b = {.options = *options,
                   .scene = scene,
                   .keep = keep,
                   .progress = progress,
                   .cells = cells,
                   .parts = parts_of(graph, &scene->forest, cells, &own),
                   .report = report,
                   .arena = &own,
                   .good = true};
    MeshOptions *whole = &b.options.mesh;
    if (whole->element == 0) whole->element = mesh_fitting_element(graph);
    whole->proxies = proxies_find(graph, whole->proxy, arena);
    whole->threads = options->rad.threads;
    report->parts = b.parts.count;
    b.weight = part_weights(&b, &own);
    // Rows of members that sleep take room on the disk, and as long to be read as to be made again.
    if (apart && b.options.rad.row_bytes == RAD_ROWS_FIT)
        b.options.rad.row_bytes = memory_left() / ROWS_APART;
    bool good =
        b.parts.count >= team_ranks() ||
        error_set(error,
                  "%s: has %d parts of %d cells at most, for %d processes: give --parts with fewer cells",
                  scene->building.source, b.parts.count, cells, team_ranks());
    if (good && apart)
        good = run_apart(&b, error);
    else
        good = good && team_run(b.parts.count, b.weight, bake_part, &b, NULL, error);
    team_last_words(NULL);
    if (good && !b.good) {
        *error = b.error;
        good = false;
    }
    if (good && team_rank() == 0 && !apart) {
        Mesh unlit;
        *doors = door_state_drawn(&scene->building, arena);
        good = (!options->doors || door_state_apply(&scene->building, options->doors, *doors, error)) &&
               joined_light(graph, whole, *doors, b.letter, b.parts.count, arena, &unlit, out, error);
        if (good) *mesh = scene_lit_mesh(scene, &unlit, arena);
        out->lit = scene->lit;
        out->lamp_count = scene->lamps.count;
    }
    arena_free(&own);
    return good;
}
