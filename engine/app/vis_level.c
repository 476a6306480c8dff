// vis_level.c - see vis_level.h. The level is read, its cells and portals are those of its leaves or of a portal file, pairs of cells are
// searched as for any building, and the level is written again with the rows that follow.
#include "engine/app/vis_level.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "engine/app/app.h"
#include "engine/core/clock.h"
#include "engine/core/memory.h"
#include "engine/core/parallel.h"
#include "engine/scene/budget.h"
#include "maps/quake/quake.h"
#include "visibility/pairs/compare.h"
#include "visibility/pairs/pairs_file.h"

static const size_t MOST_BYTES = (size_t)1 << 30;  // of a level; its numbers tell twice as many

typedef struct Job {
    const VisLevelArguments *arguments;
    Arena *arena;
    QuakeLevel level;
    QuakePortals portals;
    QuakeCells cells;
    CellGraph graph;
    PairSet set;
    uint64_t *rows, *proven, *before;  // [cluster_count * words]
    int words;
    bool had_rows;  // the level has rows already
    Bytes out;
    double seconds;
} Job;

// The portal file beside a level, NULL: there is none.
static const char *beside(const char *level, Arena *arena) {
    size_t length = strlen(level), stem = length > 4 && level[length - 4] == '.' ? length - 4 : length;
    char *path = arena_format(arena, "%.*s.prt", (int)stem, level);
    return access(path, F_OK) == 0 ? path : NULL;
}

static bool read_level(Job *j, Error *error) {
    const VisLevelArguments *a = j->arguments;
    Bytes content;
    if (!file_read(a->file, MOST_BYTES, j->arena, &content, error)) return false;
    if (!quake_recognise(content)) {
        return error_set(error,
                         "%s: is no level of the Quake family, the only files that hold visibility (-o "
                         "OUT.vis keeps stab trees "
                         "of other buildings)",
                         a->file);
    }
    if (!quake_read(a->file, content, j->arena, &j->level, error)) return false;
    bool leaves = a->portals && strcmp(a->portals, "leaves") == 0;
    j->portals = (QuakePortals){leaves       ? NULL
                                : a->portals ? a->portals
                                             : beside(a->file, j->arena),
                                a->clear_water};
    if (j->portals.file && a->clear_water) {
        return error_set(
            error,
            "%s: the portal file decides where water is clear (--clear-water goes with --portals leaves)",
            j->portals.file);
    }
    return quake_cells(&j->level, &j->portals, j->arena, &j->cells, error);
}

static uint64_t *new_rows(const Job *j) {
    return ARENA_ARRAY(j->arena, uint64_t, (size_t)j->level.cluster_count * (size_t)j->words);
}

// The rows that the level came with are for comparison alone.
static void read_rows_before(Job *j) {
    Error fault;
    j->before = new_rows(j);
    j->had_rows = j->level.lumps[QUAKE_VISIBILITY].size > 0;
    if (!j->had_rows || quake_rows(&j->level, j->words, j->before, &fault)) return;
    j->had_rows = false;
    app_warn(arena_format(j->arena, "%.900s; it is replaced", fault.text));
}

// The new level is read again: it takes its place only if it says what was found.
static bool check_out(const Job *j, Error *error) {
    QuakeLevel again;
    uint64_t *rows = new_rows(j);
    if (!quake_read(j->arguments->out, j->out, j->arena, &again, error) ||
        !quake_rows(&again, j->words, rows, error))
        return false;
    if (memcmp(rows, j->rows, (size_t)j->level.cluster_count * (size_t)j->words * sizeof *rows) == 0)
        return true;
    return error_set(error, "%s: is not written: the level would not hold the visibility that was found",
                     j->arguments->out);
}

static bool find_rows(Job *j, Error *error) {
    const VisLevelArguments *a = j->arguments;
    VisOptions options = vis_default_options();
    options.threads = a->threads;
    if (!vis_build_cells(&j->cells.building, &options, j->arena, &j->graph, error) || !memory_within(error))
        return false;
    PairSet known;
    bool goes_on = a->state && access(a->state, F_OK) == 0;
    if (goes_on && !pairs_load(a->state, &j->graph, j->arena, &known, error)) return false;
    memory_set_stage("finding which cells see each other");
    Progress progress = app_progress_stoppable(a->seconds);
    double start = clock_seconds();
    a->method->find(&j->graph, &(PairOptions){.threads = a->threads, .known = goes_on ? &known : NULL},
                    &progress, j->arena, &j->set);
    j->seconds = clock_seconds() - start;
    app_progress_end();
    j->words = (j->level.cluster_count + 63) / 64;
    j->rows = new_rows(j);
    j->proven = new_rows(j);
    quake_rows_of_cells(&j->level, &j->cells, j->set.seen, j->set.words, j->words, j->rows);
    quake_rows_of_cells(&j->level, &j->cells, j->set.proven, j->set.words, j->words, j->proven);
    read_rows_before(j);
    return memory_within(error) && quake_with_rows(&j->level, j->rows, j->words, j->arena, &j->out, error) &&
           check_out(j, error);
}

static long long undecided(const PairSet *set) {
    return pairs_compare(set->seen, set->proven, set->cell_count).beyond;
}

static void print_level_json(const Job *j) {
    int clusters = j->level.cluster_count;
    PairFigures now = pairs_compare(j->rows, j->proven, clusters);
    json_t *o = json_object();
    json_object_set_new(o, "format", json_string(QUAKE_FORMAT_NAMES[j->level.format]));
    json_object_set_new(o, "portals_from", json_string(j->portals.file ? j->portals.file : "leaves"));
    json_object_set_new(o, "method", json_string(j->arguments->method->name));
    json_object_set_new(o, "rows", json_integer(clusters));
    json_object_set_new(o, "cells", json_integer(j->graph.cell_count));
    json_object_set_new(o, "portals", json_integer(j->graph.portal_count));
    json_object_set_new(o, "visible", json_integer(now.visible));
    json_object_set_new(o, "proven", json_integer(now.bound));
    json_object_set_new(o, "undecided_cells", json_integer(undecided(&j->set)));
    if (j->had_rows) {
        PairFigures before = pairs_compare(j->before, j->proven, clusters);
        json_object_set_new(o, "visible_before", json_integer(before.visible));
        json_object_set_new(o, "missed_before", json_integer(before.missed));
    }
    json_object_set_new(o, "bytes", json_integer((json_int_t)j->out.size));
    json_object_set_new(o, "seconds", json_real(j->seconds));
    json_object_set_new(o, "stopped", json_boolean(j->set.stopped));
    app_print_json(o);
}

static void print_level(const Job *j) {
    int clusters = j->level.cluster_count;
    const char *what = j->level.format == QUAKE_IBSP38 ? "cluster" : "leaf",
               *many = j->level.format == QUAKE_IBSP38 ? "clusters" : "leaves";
    PairFigures now = pairs_compare(j->rows, j->proven, clusters);
    printf("%s: %s, %d %s; %d cells and %d portals of %s\n", j->arguments->file,
           QUAKE_FORMAT_NAMES[j->level.format], clusters, many, j->graph.cell_count, j->graph.portal_count,
           j->portals.file ? j->portals.file : "its leaves");
    printf(
        "a %s sees %.2f %s in the mean; %lld pairs of cells are undecided and count as visible%s; %.3f s\n",
        what, (double)now.visible / clusters, many, undecided(&j->set),
        j->set.stopped ? ", stopped early" : "", j->seconds);
    if (j->had_rows) {
        PairFigures before = pairs_compare(j->before, j->proven, clusters);
        printf("before a %s saw %.2f %s in the mean; %lld pairs that see each other were missing\n", what,
               (double)before.visible / clusters, many, before.missed);
    }
    printf("%s: %zu bytes\n", j->arguments->out, j->out.size);
}

static bool keep_state(const Job *j, Error *error) {
    const char *state = j->arguments->state;
    if (!state) return true;
    if (j->set.stopped) return pairs_save(state, &j->graph, &j->set, error);
    if (remove(state) != 0 && errno != ENOENT)
        return error_set(error, "%s: cannot be removed, though all is found: %s", state, strerror(errno));
    return true;
}

static bool make_level(Job *j, Error *error) {
    const VisLevelArguments *a = j->arguments;
    budget_open(a->file, a->memory, false);
    if (!read_level(j, error)) return false;
    budget_work(a->file, a->memory, "finding its visibility");
    if (!find_rows(j, error)) return false;
    return !parallel_is_first() ||
           (file_write(a->out, j->out.data, j->out.size, error) && keep_state(j, error));
}

int vis_level(const VisLevelArguments *a) {
    Arena arena = {0};
    Error error;
    Job job = {.arguments = a, .arena = &arena};
    const char *const written[] = {a->state, strcmp(a->out, a->file) == 0 ? NULL : a->out};
    const char *const read[] = {a->file, a->portals};
    bool good = app_check_files(written, 2, read, 2, NULL, &error) && file_check(a->out, 0, &error) &&
                make_level(&job, &error);
    if (good) {
        if (a->json) print_level_json(&job);
        if (!a->json) print_level(&job);
        app_print_notes(&job.cells.building, 10);
    }
    arena_free(&arena);
    if (!good) return app_fail(APP_BAD_INPUT, "%s", error.text);
    return app_interrupted() ? APP_STOPPED : APP_GOOD;
}
