// bake_parts.c - each member of the team makes the mesh of its part and finds the light there; the first one joins all light.
#include "engine/scene/bake_parts.h"

#include <string.h>

#include "engine/scene/door_state.h"
#include "radiosity/mesh/parts.h"
#include "radiosity/shoot/sky.h"
#include "radiosity/show/direct.h"
#include "radiosity/show/joined.h"

typedef struct PartsBake {
    BakeOptions options;  // with what all parts share
    const LoadedScene *scene;
    const Progress *progress;
    Parts parts;
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

// Did all members do it? Else all keep the first sentence of one that did not; who only heard of it says `stopped`.
static bool all_did(PartsBake *b, TeamMember *member, bool good, const Error *error) {
    Arena scratch = {0};
    const char *own = good ? "" : error->text, *sentence = NULL;
    const TeamBytes *said = team_collect(member, own, strlen(own) + 1, &scratch);
    for (int m = 0; m < team_count(member); m++) {
        const char *text = said[m].data;
        if (*text && (!sentence || strcmp(sentence, "stopped") == 0)) sentence = text;
    }
    if (sentence) error_set(&b->error, "%s", sentence);
    b->good = !sentence;
    arena_free(&scratch);
    return b->good;
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

static void bake_part(void *context, TeamMember *member) {
    PartsBake *b = context;
    const LoadedScene *scene = b->scene;
    Arena arena = {0};
    Error error = {"stopped"};
    Mesh mesh;
    float *doors;
    RadSolution solution;
    RadReport report = {0};
    TeamBytes letter = {0};
    bool first = team_index(member) == 0;
    // One member tells the user; when it stops, all do.
    const Progress *progress = first ? b->progress : NULL;
    BakeOptions options = b->options;
    MeshPart part = part_of(&b->parts, &scene->forest, team_index(member), options.mesh.close, &arena);
    options.member = member;
    options.mesh.part = &part;
    bool good = bake_mesh(&options, scene, NULL, progress, &arena, &doors, &mesh, &error);
    good = all_did(b, member, good, &error);
    if (good) {
        Mesh lit = scene_lit_mesh(scene, &mesh, &arena);
        RadOptions rad = fit(b, member, &lit);
        Borders *borders = borders_new(&lit, member, &arena, &error);
        rad.borders = borders;
        good = all_did(b, member, borders != NULL, &error) &&
               shine(b, member, &lit, doors, &rad, progress, &arena, &solution);
        if (good) {
            report = rad_shoot(&lit, &scene->forest, doors, &rad, progress, &solution);
            good = all_did(b, member, !report.stopped, &error);
        }
        if (good) {
            bool shown = direct_show_apart(&lit, &scene->forest, doors, rad.threads, progress, &arena,
                                           &solution, NULL, borders, &report);
            good = all_did(b, member, shown && joined_pack(&lit, &solution, doors, &arena, &letter, &error),
                           &error);
        }
    }
    if (good) {
        TeamBytes *to = ARENA_ARRAY(&arena, TeamBytes, team_count(member));
        to[0] = letter;
        const TeamBytes *from = team_exchange(member, to, first ? b->arena : &arena);
        if (first) b->letter = from;
        b->report->rad = add_work(member, report);
    }
    b->report->sent_mb = (double)team_sent(member) / 1e6;
    arena_free(&arena);
}

bool bake_parts(const BakeOptions *options, const LoadedScene *scene, int cells, const Progress *progress,
                Arena *arena, float **doors, Mesh *mesh, RadSolution *out, PartsReport *report,
                Error *error) {
    Arena own = {0};
    const CellGraph *graph = &scene->graph;
    *report = (PartsReport){.ranks = team_ranks()};
    PartsBake b = {.options = *options,
                   .scene = scene,
                   .progress = progress,
                   .parts = parts_of(graph, cells, &own),
                   .report = report,
                   .arena = &own,
                   .good = true};
    MeshOptions *whole = &b.options.mesh;
    if (whole->element == 0) whole->element = mesh_fitting_element(graph);
    whole->proxies = proxies_find(graph, whole->proxy, arena);
    whole->threads = options->rad.threads;
    report->parts = b.parts.count;
    bool good =
        b.parts.count >= team_ranks() ||
        error_set(error,
                  "%s: has %d parts of %d cells at most, for %d processes: give --parts with fewer cells",
                  scene->building.source, b.parts.count, cells, team_ranks());
    good = good && team_run(b.parts.count, bake_part, &b, error);
    if (good && !b.good) {
        *error = b.error;
        good = false;
    }
    if (good && team_rank() == 0) {
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
