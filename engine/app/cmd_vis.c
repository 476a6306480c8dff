// cmd_vis.c - `enfilade vis FILE`: makes cells, portals and stab trees, and stores the trees; or finds by another method
// which cells see each other.
#include <getopt.h>
#include <stdio.h>

#include "engine/app/vis_pairs.h"

static const char HELP[] =
    "usage: enfilade vis FILE [--map NAME] [-o OUT.vis] [--threads N] [--square M] [--max-nodes N] [--memory "
    "MB]\n"
    "                    [--json]\n"
    "       enfilade vis FILE [--map NAME] [--method NAME] [--pairs OUT.seen] [--against IN.seen] [--peer "
    "PROGRAM]\n"
    "                    [--seconds S] [--threads N] [--memory MB] [--json]\n\n"
    "Makes cells, portals and stab trees of a building and stores them: in OUT.vis, or in the user's cache, "
    "where\n"
    "the other commands find them (-o is needed where that cannot be written). The same bytes come out on\n"
    "any number of threads.\n\n"
    "  --map NAME      which one of a file that holds several maps (default: the first)\n"
    "  -o OUT.vis      where to write\n"
    "  --threads N     threads to use, 1 to 256 (default: all cores)\n"
    "  --square M      side of the mesh squares in cells, metres, 0.25 to 100 (default 1)\n"
    "  --max-nodes N   largest stab tree of a cell, 1 to 10000000 (default 5000); a larger one keeps its "
    "visible set\n"
    "  --memory MB     memory that may be used, 16 to 1000000 (default: what fits the file)\n"
    "  --json          one JSON object on standard output\n\n"
    "With one of the following, no trees: a method finds which cells see each other. It can be stopped at "
    "any\n"
    "moment (Ctrl-C): what was not excluded until then counts as visible, and is written all the same.\n\n"
    "  --method NAME   one of those below, from the coarsest to the finest (default: the last)\n"
    "  --pairs FILE    writes the matrix, bit by bit, as a .seen file\n"
    "  --against FILE  compares with a .seen file of proven pairs; exit status 1 when one of them is missed\n"
    "  --peer PROGRAM  runs a visibility compiler for Quake levels on the same portal file, for comparison\n"
    "  --seconds S     stops after S seconds, 0.001 to 1e6\n\n"
    "methods:\n";

typedef struct Arguments {
    AppOptions load;
    VisPairsArguments pairs;
    const char *file, *out;
    bool json, help, wants_pairs;
} Arguments;

enum { METHOD = 256, PAIRS, AGAINST, PEER, SECONDS };

static int parse_pairs_option(int c, char **argv, Arguments *a) {
    a->wants_pairs = true;
    switch (c) {
    case METHOD:
        a->pairs.method = optarg;
        if (pair_method(optarg)) return APP_GOOD;
        return app_misuse("vis", "vis: --method is `%s` (see --help for those allowed)", optarg);
    case PAIRS:
        a->pairs.out = optarg;
        return APP_GOOD;
    case AGAINST:
        a->pairs.against = optarg;
        return APP_GOOD;
    case PEER:
        a->pairs.peer = optarg;
        return APP_GOOD;
    case SECONDS:
        if (app_parse_number(optarg, 0.001, 1e6, &a->pairs.seconds)) return APP_GOOD;
        return app_misuse("vis", "vis: --seconds is `%s` (allowed 0.001 to 1e6)", optarg);
    default:
        return app_misuse_option("vis", c, argv);
    }
}

static int parse_option(int c, char **argv, Arguments *a) {
    switch (c) {
    case 'j':
        a->json = true;
        return APP_GOOD;
    case 'h':
        a->help = true;
        return APP_GOOD;
    case 'm':
        a->load.map = optarg;
        return APP_GOOD;
    case 'y':
        return app_take_memory("vis", optarg);
    case 'o':
        a->out = optarg;
        return APP_GOOD;
    case 't':
        if (app_parse_int(optarg, 1, 256, &a->load.vis.threads)) return APP_GOOD;
        return app_misuse("vis", "vis: --threads is `%s` (allowed 1 to 256)", optarg);
    case 's':
        if (app_parse_number(optarg, 0.25, 100, &a->load.vis.square)) return APP_GOOD;
        return app_misuse("vis", "vis: --square is `%s` (allowed 0.25 to 100)", optarg);
    case 'n':
        if (app_parse_int(optarg, 1, 10000000, &a->load.vis.max_nodes)) return APP_GOOD;
        return app_misuse("vis", "vis: --max-nodes is `%s` (allowed 1 to 10000000)", optarg);
    default:
        return parse_pairs_option(c, argv, a);
    }
}

static int parse(int argc, char **argv, Arguments *a) {
    static const struct option options[] = {{"json", no_argument, NULL, 'j'},
                                            {"help", no_argument, NULL, 'h'},
                                            {"map", required_argument, NULL, 'm'},
                                            {"memory", required_argument, NULL, 'y'},
                                            {"threads", required_argument, NULL, 't'},
                                            {"square", required_argument, NULL, 's'},
                                            {"max-nodes", required_argument, NULL, 'n'},
                                            {"method", required_argument, NULL, METHOD},
                                            {"pairs", required_argument, NULL, PAIRS},
                                            {"against", required_argument, NULL, AGAINST},
                                            {"peer", required_argument, NULL, PEER},
                                            {"seconds", required_argument, NULL, SECONDS},
                                            {0}};
    opterr = 0;
    for (int c; (c = getopt_long(argc, argv, ":ho:", options, NULL)) != -1;) {
        int code = parse_option(c, argv, a);
        if (code != APP_GOOD || a->help) return code;
    }
    if (argc - optind != 1)
        return app_misuse("vis", "vis: one building file is needed, %d were given", argc - optind);
    if (a->wants_pairs && a->out)
        return app_misuse("vis",
                          "vis: -o stores stab trees, which a method does not make (allowed: --pairs)");
    a->file = argv[optind];
    return APP_GOOD;
}

// Polygons registered in the cells that `from` may see, each once. `row`: these cells.
static long polygons_seen(const AppScene *scene, int from, const uint64_t *row, int *stamp) {
    const CellGraph *graph = &scene->graph;
    long polygons = 0;
    for (int c = 0; c < graph->cell_count; c++) {
        if (!row[c / 64]) c |= 63;
        if (c >= graph->cell_count || !(row[c / 64] >> (c % 64) & 1)) continue;
        const CellMesh *mesh = &graph->meshes[c];
        int first = graph->square_first[mesh->first_square];
        int end = graph->square_first[mesh->first_square + mesh->nx * mesh->ny];
        for (int k = first; k < end; k++) {
            int object = graph->square_objects[k];
            if (stamp[object] == from + 1) continue;
            stamp[object] = from + 1;
            polygons += graph->objects[object].polygon_count;
        }
    }
    return polygons;
}

// Mean share of the cells, and of all polygons, that a cell may see.
static void cell_to_cell(const AppScene *scene, double *cells, double *polygons) {
    const CellGraph *graph = &scene->graph;
    Arena scratch = {0};
    int *stamp = ARENA_ARRAY(&scratch, int, graph->object_count + 1);
    uint64_t *row = ARENA_ARRAY(&scratch, uint64_t, scene->forest.words);
    double seen_cells = (double)cell_rows_count(&scene->forest.seen), seen_polygons = 0;
    for (int c = 0; c < graph->cell_count; c++) {
        memset(row, 0, (size_t)scene->forest.words * sizeof *row);
        cell_rows_join(&scene->forest.seen, c, row);
        seen_polygons += (double)polygons_seen(scene, c, row, stamp);
    }
    *cells = seen_cells / graph->cell_count / graph->cell_count;
    *polygons = graph->polygon_count ? seen_polygons / graph->cell_count / graph->polygon_count : 0;
    arena_free(&scratch);
}

static int bounded_trees(const StabForest *forest) {
    int count = 0;
    for (int c = 0; c < forest->cell_count; c++) count += forest->bounded[c];
    return count;
}

static void print_result(const Arguments *a, const AppScene *scene) {
    double cells, polygons, seconds = scene->cells_seconds + scene->trees_seconds;
    cell_to_cell(scene, &cells, &polygons);
    if (a->json) {
        json_t *o = app_counts(scene);
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
           "and %.1f %% of the polygons in the mean\n",
           scene->graph.cell_count, scene->graph.portal_count, scene->forest.node_count, 100 * cells,
           100 * polygons);
    printf("%lld pairs of cells undecided; %d trees too large, of which the visible set is kept%s\n",
           scene->undecided, bounded_trees(&scene->forest),
           scene->stopped ? "; stopped early: what was not excluded until then counts as visible" : "");
    printf("read %.3f s, cells %.3f s, visible sets and stab trees %.3f s\n", scene->read_seconds,
           scene->cells_seconds, scene->trees_seconds);
}

// Storing is all that this command is for.
static bool check_place(const Arguments *a, Arena *arena, Error *error) {
    Error reason;
    if (a->out) return app_check_files(&a->out, 1, &a->file, 1, error);
    if (app_cache_check(app_cache_path(arena, "trees.vis"), 0, &reason)) return true;
    return error_set(error, "%.900s: the stab trees cannot be stored (-o OUT.vis stores them elsewhere)",
                     reason.text);
}

int cmd_vis(int argc, char **argv) {
    Arguments a = {.load = app_default_options()};
    int code = parse(argc, argv, &a);
    if (code != APP_GOOD) return code;
    if (a.help) {
        fputs(HELP, stdout);
        for (int i = 0; PAIR_METHODS[i]; i++)
            printf("  %-8s  %s\n", PAIR_METHODS[i]->name, PAIR_METHODS[i]->summary);
        return APP_GOOD;
    }
    if (a.wants_pairs) {
        a.pairs.file = a.file;
        a.pairs.load = a.load;
        a.pairs.json = a.json;
        return vis_pairs(&a.pairs);
    }
    a.load.fresh = true;
    a.load.keep = !a.out;
    a.load.stoppable = true;
    Arena arena = {0};
    AppScene scene;
    Error error;
    bool good = check_place(&a, &arena, &error) && app_load(a.file, &a.load, &arena, &scene, &error) &&
                (!a.out || vis_save(a.out, &scene.graph, &scene.forest, &error));
    if (good) {
        print_result(&a, &scene);
        app_print_notes(&scene.building, 10);
    }
    // Where they could not be kept, that was said.
    bool stored = good && (a.out || scene.kept || scene.stopped);
    arena_free(&arena);
    if (!good) app_fail(APP_BAD_INPUT, "%s", error.text);
    return stored ? APP_GOOD : APP_BAD_INPUT;
}
