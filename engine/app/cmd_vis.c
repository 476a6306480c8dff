// cmd_vis.c - `enfilade vis FILE`: makes cells, portals and stab trees, and stores the trees; or finds by another method
// which cells see each other.
#include <stddef.h>
#include <stdio.h>

#include "engine/app/app.h"
#include "engine/app/vis_level.h"
#include "engine/core/clock.h"
#include "engine/core/memory.h"
#include "engine/core/parallel.h"
#include "visibility/pairs/compare.h"
#include "visibility/pairs/pairs.h"
#include "visibility/pairs/seen_file.h"

typedef struct VisPairsArguments {
    const char *file;
    SceneOptions load;    // its threads are the method's
    const char *method;   // NULL: the finest
    const char *out;      // where the matrix goes, or NULL
    const char *against;  // a .seen file to compare with, or NULL
    double seconds;       // to stop after; 0: when done
    bool json;
} VisPairsArguments;

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
    if (o->scene.graph.cell_count > MAPS_MAX_GIVEN_CELLS)
        return error_set(
            error,
            "%s: has %d cells (allowed with --pairs-method: %d, as many as a matrix of pairs has room for)",
            a->file, o->scene.graph.cell_count, MAPS_MAX_GIVEN_CELLS);
    // Before the work: a file that cannot be used is better known at once.
    if (a->against && !seen_read(a->against, o->scene.graph.cell_count, arena, &bound, error)) return false;
    memory_set_stage("finding which cells see each other");
    find_pairs(a, arena, o);
    if (a->out && parallel_is_first() && !seen_write(a->out, o->set.seen, o->set.cell_count, error))
        return false;
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

// Returns the exit code: APP_BAD_INPUT also where a pair of `against` is missed.
static int vis_pairs(const VisPairsArguments *a) {
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

typedef struct Arguments {
    SceneOptions load;
    VisPairsArguments pairs;
    VisLevelArguments level;
    const char *file, *out;
    bool json, in_place, fast;
} Arguments;

static int take_method(const char *name, void *arguments, Error *error) {
    ((Arguments *)arguments)->pairs.method = name;
    if (pair_method(name)) return APP_GOOD;
    error_set(error, "those that --help lists");
    return APP_BAD_USE;
}

enum { OUT_VIS, OUT_BSP, OUT_COUNT };
static const char *const OUT_ENDINGS[OUT_COUNT] = {"vis", "bsp"};

static const Option ROWS[] = {
    OPTION_MAP(offsetof(Arguments, load.map)),
    {.name = "o",
     .value = "OUT",
     .type = OPTION_OUTPUT,
     .names = OUT_ENDINGS,
     .name_count = OUT_COUNT,
     .at = offsetof(Arguments, out),
     .help = "OUT.vis: the trees (default: in the user's cache); OUT.bsp: the level with its visibility"},
    OPTION_THREADS(offsetof(Arguments, load.vis.threads)),
    {.name = "square",
     .value = "M",
     .type = OPTION_NUMBER,
     .at = offsetof(Arguments, load.vis.square),
     .low = 0.25,
     .high = 100,
     .help = "side of the squares in cells, metres, @ (default 1)"},
    {.name = "max-nodes",
     .value = "N",
     .type = OPTION_INT,
     .at = offsetof(Arguments, load.vis.max_nodes),
     .low = 1,
     .high = 10000000,
     .help = "largest stab tree of a cell, @ (default 5000); a larger one keeps its visible set"},
    OPTION_MEMORY(offsetof(Arguments, load.memory), "what fits the file"),
    OPTION_JSON(offsetof(Arguments, json)),
    {.type = OPTION_HEADING,
     .help = "Of a Quake or Quake II level, with -o OUT.bsp or --in-place, the level is written with the "
             "visibility of its leaves. "
             "Stopped early (Ctrl-C, --seconds), what was not excluded until then counts as visible."},
    {.name = "in-place",
     .type = OPTION_FLAG,
     .at = offsetof(Arguments, in_place),
     .help = "replaces the level itself, once the new one is whole"},
    {.name = "portals",
     .value = "FILE.prt",
     .type = OPTION_TEXT,
     .at = offsetof(Arguments, level.portals),
     .help = "portals of the level's compiler (default: MAP.prt beside MAP.bsp), or `leaves`: they are made "
             "from the leaves of "
             "the level, so that details hide what is behind them (default where there is no MAP.prt)"},
    {.name = "clear-water",
     .type = OPTION_FLAG,
     .at = offsetof(Arguments, level.clear_water),
     .help = "with portals made from leaves, sight passes the surfaces of water, slime and lava"},
    {.name = "state",
     .value = "FILE",
     .type = OPTION_OUTPUT,
     .names = (const char *const[]){"pairs"},
     .name_count = 1,
     .at = offsetof(Arguments, level.state),
     .help = "FILE.pairs: stopped early, what was found goes there, and the next run goes on from it"},
    {.name = "fast",
     .type = OPTION_FLAG,
     .at = offsetof(Arguments, fast),
     .help = "a draft by the first of the methods below, in seconds for any level"},
    {.type = OPTION_HEADING,
     .help =
         "With one of the following, no trees: a method finds which cells see each other. It can be stopped "
         "at any "
         "moment (Ctrl-C): a pair that was not excluded until then counts as visible, and all are written."},
    {.name = "pairs-method",
     .value = "NAME",
     .type = OPTION_OTHER,
     .take = take_method,
     .help = "one of those below, from the coarsest to the finest (default: the last); of a level, too"},
    {.name = "pairs",
     .value = "OUT.seen",
     .type = OPTION_TEXT,
     .at = offsetof(Arguments, pairs.out),
     .help = "writes the matrix, bit by bit, as a .seen file"},
    {.name = "against",
     .value = "IN.seen",
     .type = OPTION_TEXT,
     .at = offsetof(Arguments, pairs.against),
     .help = "compares with a .seen file of proven pairs; exit status 1 when one of them is missed"},
    {.name = "seconds",
     .value = "S",
     .type = OPTION_NUMBER,
     .at = offsetof(Arguments, pairs.seconds),
     .low = 0.001,
     .high = 1e6,
     .help = "stops after S seconds, @; of a level, too"},
};
static const OptionTable OPTIONS =
    OPTION_TABLE("vis",
                 "FILE [-o OUT.vis] [OPTIONS]\n"
                 "MAP.bsp (-o OUT.bsp | --in-place) [OPTIONS]\n"
                 "FILE [--pairs-method NAME] [--pairs OUT.seen] [--against IN.seen] [--seconds S] [OPTIONS]",
                 "Makes cells, portals and stab trees of a building and stores them: in OUT.vis, or in the "
                 "user's cache, where the "
                 "other commands find them (-o is needed where that cannot be written). The same bytes come "
                 "out on any number of "
                 "threads.",
                 ROWS);

static int check_level(Arguments *a, bool pairs, bool matrix) {
    static const char WITHOUT[] = "vis: --in-place, --portals, --clear-water, --state and --fast are for "
                                  "levels (allowed: with -o OUT.bsp or "
                                  "--in-place)";
    bool bsp = a->out && options_ending(a->out, OUT_ENDINGS, OUT_COUNT) == OUT_BSP;
    if (!bsp && !a->in_place) {
        if (a->level.portals || a->level.clear_water || a->level.state || a->fast)
            return app_misuse("vis", "%s", WITHOUT);
        if (pairs && a->out)
            return app_misuse("vis",
                              "vis: -o stores stab trees, which a method does not make (allowed: --pairs)");
        return APP_GOOD;
    }
    if (a->in_place && a->out)
        return app_misuse("vis", "vis: --in-place writes MAP.bsp itself (allowed: that, or -o OUT.bsp)");
    if (matrix)
        return app_misuse(
            "vis", "vis: --pairs and --against are about a matrix (allowed: without OUT.bsp and --in-place)");
    if (a->fast && a->pairs.method)
        return app_misuse("vis", "vis: --fast is a method (allowed: that, or --pairs-method)");
    a->level.file = a->file;
    a->level.out = a->in_place ? a->file : a->out;
    a->level.method = a->fast           ? PAIR_METHODS[0]
                      : a->pairs.method ? pair_method(a->pairs.method)
                                        : pair_method_finest();
    a->level.threads = a->load.vis.threads;
    a->level.seconds = a->pairs.seconds;
    a->level.memory = a->load.memory;
    a->level.json = a->json;
    return APP_GOOD;
}

static int parse_vis(int argc, char **argv, Arguments *a, bool *help, bool *wants_pairs) {
    bool given[sizeof ROWS / sizeof *ROWS] = {false};
    int code = options_parse_file(&OPTIONS, argc, argv, a, given, &a->file, help);
    if (code != APP_GOOD || *help) return code;
    static const char *const names[] = {"pairs-method", "pairs", "against", "seconds"};
    for (int i = 0; i < 4; i++) *wants_pairs |= options_given(&OPTIONS, given, names[i]);
    return check_level(a, *wants_pairs, a->pairs.out || a->pairs.against);
}

static void print_vis_help(void) {
    options_print_help(&OPTIONS);
    puts("\nmethods:");
    for (int i = 0; PAIR_METHODS[i]; i++)
        printf("  %-8s  %s\n", PAIR_METHODS[i]->name, PAIR_METHODS[i]->summary);
}

static const double MOST_LOOKS = 4e6;

// Polygons registered in the cells that `from` may see, each once. `row`: these cells.
static long polygons_seen(const LoadedScene *scene, int from, const uint64_t *row, int *stamp) {
    const CellGraph *graph = &scene->graph;
    long polygons = 0;
    for (int c = 0; c < graph->cell_count; c++) {
        if (!row[c / 64]) c |= 63;
        if (c >= graph->cell_count || !(row[c / 64] >> (c % 64) & 1)) continue;
        const SquareGrid *grid = &graph->grids[c];
        int first = graph->square_first[grid->first_square];
        int end = graph->square_first[grid->first_square + grid->nx * grid->ny];
        for (int k = first; k < end; k++) {
            int object = graph->square_objects[k];
            if (stamp[object] == from + 1) continue;
            stamp[object] = from + 1;
            polygons += graph->objects[object].polygon_count;
        }
    }
    return polygons;
}

// Mean share of the cells, and of all polygons, that a cell may see. Polygons are counted from every cell of a building with at most
// MOST_LOOKS pairs of cells that may see each other, else from cells at even distances, with about so many pairs; then the result is false.
static bool cell_to_cell(const LoadedScene *scene, double *cells, double *polygons) {
    const CellGraph *graph = &scene->graph;
    Arena scratch = {0};
    int *stamp = ARENA_ARRAY(&scratch, int, graph->object_count + 1);
    uint64_t *row = ARENA_ARRAY(&scratch, uint64_t, scene->forest.words);
    double seen_cells = (double)cell_rows_count(&scene->forest.seen), seen_polygons = 0;
    int step = (int)ceil(seen_cells / MOST_LOOKS), from = 0;
    for (int c = 0; c < graph->cell_count; c += step, from++) {
        memset(row, 0, (size_t)scene->forest.words * sizeof *row);
        cell_rows_join(&scene->forest.seen, c, row);
        seen_polygons += (double)polygons_seen(scene, c, row, stamp);
    }
    *cells = seen_cells / graph->cell_count / graph->cell_count;
    *polygons = graph->polygon_count ? seen_polygons / from / graph->polygon_count : 0;
    arena_free(&scratch);
    return step <= 1;
}

static int bounded_trees(const StabForest *forest) {
    int count = 0;
    for (int c = 0; c < forest->cell_count; c++) count += forest->bounded[c];
    return count;
}

static void print_vis(const Arguments *a, const LoadedScene *scene) {
    double cells, polygons, seconds = scene->cells_seconds + scene->trees_seconds;
    bool exact = cell_to_cell(scene, &cells, &polygons);
    if (a->json) {
        json_t *o = app_counts(scene);
        json_object_set_new(o, "stab_nodes", json_integer(scene->forest.node_count));
        json_object_set_new(o, "bounded_trees", json_integer(bounded_trees(&scene->forest)));
        json_object_set_new(o, "cell_to_cell", json_real(cells));
        json_object_set_new(o, "cell_to_cell_polygons", json_real(polygons));
        json_object_set_new(o, "read_seconds", json_real(scene->read_seconds));
        json_object_set_new(o, "cells_seconds", json_real(scene->cells_seconds));
        json_object_set_new(o, "trees_seconds", json_real(scene->trees_seconds));
        json_object_set_new(o, "vis_seconds", json_real(seconds));
        json_object_set_new(o, "undecided", json_integer(scene->undecided));
        json_object_set_new(o, "stopped", json_boolean(scene->stopped));
        app_print_json(o);
        return;
    }
    printf("%d cells, %d portals, %d stab nodes; a cell sees %.1f %% of the cells "
           "and %s%.1f %% of the polygons in the mean\n",
           scene->graph.cell_count, scene->graph.portal_count, scene->forest.node_count, 100 * cells,
           exact ? "" : "about ", 100 * polygons);
    printf("%lld pairs of cells undecided; %d trees too large, of which the visible set is kept%s\n",
           scene->undecided, bounded_trees(&scene->forest),
           scene->stopped ? "; stopped early: what was not excluded until then counts as visible" : "");
    printf("read %.3f s, cells %.3f s, visible sets and stab trees %.3f s\n", scene->read_seconds,
           scene->cells_seconds, scene->trees_seconds);
}

// The only purpose of this command is to store the stab trees, so it fails where they cannot be stored.
static bool check_place(Arguments *a, Arena *arena, Error *error) {
    Error reason;
    if (a->out) return app_check_files(&a->out, 1, &a->file, 1, &a->load, error);
    if (scene_cache_check(scene_cache_path(arena, "trees.vis"), 0, &reason)) return true;
    return error_set(error, "%.900s: the stab trees cannot be stored (-o OUT.vis stores them elsewhere)",
                     reason.text);
}

int cmd_vis(int argc, char **argv) {
    Arguments a = {.load = app_scene_options()};
    bool help = false, wants_pairs = false;
    int code = parse_vis(argc, argv, &a, &help, &wants_pairs);
    if (help) print_vis_help();
    if (code != APP_GOOD || help) return code;
    if (a.level.out) return vis_level(&a.level);
    if (wants_pairs) {
        a.pairs.file = a.file;
        a.pairs.load = a.load;
        a.pairs.json = a.json;
        return vis_pairs(&a.pairs);
    }
    a.load.fresh = true;
    a.load.keep = !a.out;
    a.load.progress = app_progress_stoppable(0);
    Arena arena = {0};
    LoadedScene scene;
    Error error;
    bool good = check_place(&a, &arena, &error) && app_load(a.file, &a.load, &arena, &scene, &error) &&
                (!a.out || !parallel_is_first() || vis_save(a.out, &scene.graph, &scene.forest, &error));
    if (good) {
        print_vis(&a, &scene);
        app_print_notes(&scene.building, 10);
    }
    // Where they could not be kept, that was said.
    bool stored = good && (a.out || scene.kept || scene.stopped);
    arena_free(&arena);
    if (!good) app_fail(APP_BAD_INPUT, "%s", error.text);
    return stored ? APP_GOOD : APP_BAD_INPUT;
}
