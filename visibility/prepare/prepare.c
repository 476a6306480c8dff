// prepare.c - from a building to cells and stab trees: which cells see each other by the finest method, then the trees within that.
#include "visibility/prepare/prepare.h"

#include <unistd.h>

#include "engine/core/file.h"
#include "engine/core/memory.h"
#include "engine/core/parallel.h"
#include "visibility/pairs/campus.h"

VisPrepareOptions vis_prepare_default_options(void) {
    return (VisPrepareOptions){.vis = vis_default_options()};
}

// Stopped on the way, trees are roots alone, and visible sets hold all pairs that were not excluded.
static void make_forest(const VisPrepareOptions *options, const Progress *progress, Arena *arena,
                        VisPrepared *out) {
    Arena scratch = {0};
    CampusPairs pairs = {.stopped = false};
    VisOptions vis = options->vis;
    memory_set_stage("finding which cells see each other");
    PairOptions pair_options = {.threads = vis.threads};
    bool known = campus_pairs(&out->graph, &pair_options, progress, &scratch, &pairs);
    if (known) vis.known = &pairs.seen;
    memory_set_stage("making stab trees");
    out->stopped = pairs.stopped || !vis_build_forest(&out->graph, &vis, progress, arena, &out->forest);
    if (out->stopped) {
        vis.max_nodes = 1;
        vis_build_forest(&out->graph, &vis, NULL, arena, &out->forest);
    }
    out->undecided = known ? pairs.undecided : cell_rows_count(&out->forest.seen) - out->graph.cell_count;
    arena_free(&scratch);
}

// Whether the file can be written is asked before hours of work rather than after them.
static void read_or_make_forest(const VisPrepareOptions *options, const Progress *progress, Arena *arena,
                                VisPrepared *out) {
    const char *file = options->file;
    if (file && !options->fresh && access(file, R_OK) == 0) {
        out->read = out->kept = vis_load(file, &out->graph, arena, &out->forest, &out->not_read);
    }
    // Processes that share the work all read it, or all make it.
    out->read = parallel_agree(out->read);
    if (out->read) return;
    bool write = file && parallel_is_first() && !options->read_only && file_check(file, 0, &out->not_kept);
    make_forest(options, progress, arena, out);
    if (write && !out->stopped) out->kept = vis_save(file, &out->graph, &out->forest, &out->not_kept);
}

bool vis_prepare(const Building *building, const VisPrepareOptions *options, const Progress *progress,
                 Arena *arena, VisPrepared *out, Error *error) {
    *out = (VisPrepared){0};
    if (options->graph) {
        out->graph = *options->graph;
    } else {
        memory_set_stage("making cells");
        if (!vis_build_cells(building, &options->vis, arena, &out->graph, error) || !memory_within(error))
            return false;
        memory_lower_fence();
        progress_report(progress, "cells", 1);
    }
    read_or_make_forest(options, progress, arena, out);
    return true;
}
