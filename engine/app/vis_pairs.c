// vis_pairs.c - runs a cell-to-cell method, writes what it found, and compares it.
#include "engine/app/vis_pairs.h"

#include <stdio.h>

#include "engine/core/clock.h"
#include "engine/core/memory.h"
#include "visibility/pairs/compare.h"
#include "visibility/pairs/seen_file.h"

typedef struct Outcome {
    LoadedScene scene;
    const PairMethod *method;
    PairSet set;
    double seconds;
    uint64_t
        *checked;  // pairs whose sightlines hold when walked again, or that have one, where none are walked
    long long refuted;
    bool compared;
    PairFigures plain, counting_witnesses;  // against the file, and against it and the checked sightlines
} Outcome;

static void compare(uint64_t *bound, Outcome *o) {
    int cells = o->set.cell_count;
    o->plain = pairs_compare(o->set.seen, bound, cells);
    pairs_unite(o->checked, cells, bound);
    o->counting_witnesses = pairs_compare(o->set.seen, bound, cells);
    o->compared = true;
}

static void find_pairs(const VisPairsArguments *a, Arena *arena, Outcome *o) {
    // Sightlines, millions in a large map, are kept only where they are to be walked again.
    PairOptions options = {.threads = a->load.vis.threads, .witnesses = a->against != NULL};
    Progress progress = app_progress_stoppable(a->seconds);
    double start = clock_seconds();
    o->method->find(&o->scene.graph, &options, &progress, arena, &o->set);
    o->seconds = clock_seconds() - start;
    app_progress_end();
    o->checked = o->set.proven;
    if (!options.witnesses) return;
    o->checked = ARENA_ARRAY(arena, uint64_t, (size_t)o->set.cell_count * (size_t)o->set.words);
    o->refuted = pairs_check_witnesses(&o->scene.graph, &o->set, o->checked);
}

static bool run_pairs(const VisPairsArguments *a, Arena *arena, Outcome *o, Error *error) {
    uint64_t *bound = NULL;
    const char *read[] = {a->file, a->against};
    SceneOptions load = a->load;
    if (!app_check_files(&a->out, 1, read, 2, &load, error) ||
        !scene_load_cells(a->file, &load, arena, &o->scene, error))
        return false;
    // Before the work: a file that cannot be used is better known at once.
    if (a->against && !seen_read(a->against, o->scene.graph.cell_count, arena, &bound, error)) return false;
    memory_set_stage("finding which cells see each other");
    find_pairs(a, arena, o);
    if (a->out && !seen_write(a->out, o->set.seen, o->set.cell_count, error)) return false;
    if (bound) compare(bound, o);
    return true;
}

// Pairs of cells in the set without a sightline that holds, both ways round.
static long long undecided(const Outcome *o) {
    return pairs_compare(o->set.seen, o->checked, o->set.cell_count).beyond;
}

static void print_json(const Outcome *o) {
    const PairSet *set = &o->set;
    json_t *j = json_object();
    json_object_set_new(j, "method", json_string(o->method->name));
    json_object_set_new(j, "cells", json_integer(set->cell_count));
    json_object_set_new(j, "portals", json_integer(o->scene.graph.portal_count));
    json_object_set_new(j, "pairs", json_integer(pair_count(set->seen, set->cell_count, set->words)));
    json_object_set_new(j, "undecided", json_integer(undecided(o)));
    json_object_set_new(j, "refuted_witnesses", json_integer(o->refuted));
    json_object_set_new(j, "seconds", json_real(o->seconds));
    json_object_set_new(j, "stopped", json_boolean(set->stopped));
    if (o->compared) {
        json_object_set_new(j, "proven", json_integer(o->plain.bound));
        json_object_set_new(j, "over_percent", json_real(pairs_over(&o->plain)));
        json_object_set_new(j, "over_percent_with_witnesses", json_real(pairs_over(&o->counting_witnesses)));
        json_object_set_new(j, "misses", json_integer(o->plain.missed));
    }
    app_print_json(j);
}

static void print_comparison(const VisPairsArguments *a, const Outcome *o) {
    const PairFigures *f = &o->plain;
    printf("against %s: %lld pairs proven there, %lld missed; over %.3f %%, counting checked sightlines as "
           "proven "
           "%.3f %%\n",
           a->against, f->bound, f->missed, pairs_over(f), pairs_over(&o->counting_witnesses));
    if (f->missed > 0) printf("missed first: cells %d and %d\n", f->miss[0], f->miss[1]);
}

static void print_text(const VisPairsArguments *a, const Outcome *o) {
    const PairSet *set = &o->set;
    long long pairs = pair_count(set->seen, set->cell_count, set->words);
    printf("%s: %d cells, %d portals; a cell sees %.2f cells in the mean, itself among them\n",
           o->method->name, set->cell_count, o->scene.graph.portal_count, (double)pairs / set->cell_count);
    printf("%lld pairs visible, %lld of them undecided%s, %.3f s\n", pairs, undecided(o),
           set->stopped ? "; stopped early: what was not excluded until then counts as visible" : "",
           o->seconds);
    if (o->refuted > 0) printf("%lld sightlines did not hold when walked again\n", o->refuted);
    if (o->compared) print_comparison(a, o);
}

int vis_pairs(const VisPairsArguments *a) {
    Outcome outcome = {.method = a->method ? pair_method(a->method) : pair_method_finest()};
    if (!outcome.method) return app_misuse("vis", "vis: there is no method `%s`", a->method);
    Arena arena = {0};
    Error error;
    bool good = run_pairs(a, &arena, &outcome, &error);
    if (good && a->json) print_json(&outcome);
    if (good && !a->json) print_text(a, &outcome);
    bool missed = outcome.compared && outcome.plain.missed > 0;
    arena_free(&arena);
    if (!good) return app_fail(APP_BAD_INPUT, "%s", error.text);
    return missed ? APP_BAD_INPUT : APP_GOOD;
}
