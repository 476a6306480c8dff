// fuzz_vis.c - libFuzzer on the .vis reader: a file is refused with a sentence, or it holds trees and sets that a query can
// walk.
#include <stdlib.h>

#include "tests/fuzz/store_target.h"

// All cells from the middle of each, through trees, sets and neither.
static void walk(const CellGraph *graph, const StabForest *forest, Arena *arena) {
    VisQuery *query = vis_query_new(graph, forest, arena);
    for (int c = 0; c < graph->cell_count; c++) {
        Box box = graph->cells[c].box;
        Eye eye = {.position = vec3_scale(vec3_add(box.min, box.max), 0.5)};
        for (int method = 0; method < QUERY_CULLINGS; method++)
            vis_query(query, &eye, vis_locate(graph, eye.position, c), NULL, (Culling)method);
    }
}

static void make(StoreTarget *t) {
    store_target_start(t);
    if (!vis_save(t->saved, &t->graph, &t->forest, NULL)) abort();
    store_target_keep(t);
    store_target_put_valid(t);
    StabForest forest;
    if (!vis_load(t->path, &t->graph, &t->arena, &forest, NULL)) abort();
}

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    static StoreTarget target = {.header = 56};  // of vis_file.c
    if (!target.valid.data) make(&target);
    Arena *arena = target_begin();
    store_target_put(&target, data, size, arena);
    StabForest forest;
    Error error = {""};
    if (vis_load(target.path, &target.graph, arena, &forest, &error)) {
        walk(&target.graph, &forest, arena);
        target_count(TARGET_PASSED);
    } else if (error.text[0] == 0) {
        abort();
    }
    return 0;
}
