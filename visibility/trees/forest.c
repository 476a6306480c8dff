// forest.c - the stab trees of all cells, and who sees whom.
//
// Cells are independent of each other, so the threads do not show in the result. Visibility is symmetric: the sets
// are intersected with their transpose, and the trees cut accordingly. A cell that has more sequences than allowed keeps
// no tree, and the cells that may be seen as the caller knows are its visible set.
#include <pthread.h>
#include <string.h>

#include "engine/core/memory.h"
#include "engine/core/parallel.h"
#include "visibility/trees/forest.h"
#include "visibility/ways.h"

// The data that all threads share.
typedef struct Growth {
    TreeGrower **growers;  // [threads], as are these
    uint64_t **rows;       // [words] of the cell at hand
    Arena *own;            // blocks of rows
    StabForest *forest;
    Tree *trees;
    int first;          // cell of this run
    long long allowed;  // work for one tree of it
    const Progress *progress;
    pthread_mutex_t lock;  // of `progress`, `done` and `stopped`
    int done;
    bool stopped;
} Growth;

static void grow_next(void *context, int index, int thread) {
    Growth *growth = context;
    int cell = growth->first + index;
    pthread_mutex_lock(&growth->lock);
    double done = (double)growth->done++ / growth->forest->cell_count;
    if (!growth->stopped && !progress_report(growth->progress, "stab trees", done)) growth->stopped = true;
    bool stopped = growth->stopped;
    pthread_mutex_unlock(&growth->lock);
    if (stopped) return;
    StabForest *forest = growth->forest;
    uint64_t *row = growth->rows[thread];
    memset(row, 0, (size_t)forest->words * sizeof *row);
    growth->trees[cell] = tree_grow(growth->growers[thread], cell, growth->allowed, row);
    cell_rows_set(&forest->seen, cell, row, &growth->own[thread]);
}

// In runs, so that what trees take is known before the next are grown: one may take much more than its share of what is left, since
// most take less.
static void grow_all(Growth *growth, const TreeSource *source, int threads, Arena *scratch) {
    enum { RUN = 64, TIMES = 64, MOST = 8 };
    int count = growth->forest->cell_count;
    growth->growers = ARENA_ARRAY(scratch, TreeGrower *, threads);
    growth->rows = ARENA_ARRAY(scratch, uint64_t *, threads);
    growth->own = ARENA_ARRAY(scratch, Arena, threads);
    for (int i = 0; i < threads; i++) {
        growth->growers[i] = tree_grower_new(source, scratch);
        growth->rows[i] = ARENA_ARRAY(scratch, uint64_t, growth->forest->words);
    }
    long long left = tree_work(source);
    for (growth->first = 0; growth->first < count && !growth->stopped; growth->first += RUN) {
        int rest = count - growth->first, run = rest < RUN ? rest : RUN;
        long long share = left / rest * TIMES;
        growth->allowed = share < left / MOST ? share : left / MOST;
        parallel_for(threads, run, grow_next, growth);
        for (int i = 0; i < run; i++) {
            const Tree *tree = &growth->trees[growth->first + i];
            left -= tree->spent * (tree->bounded ? tree_waste(source) : 1);
        }
    }
    for (int i = 0; i < threads; i++) tree_grower_end(growth->growers[i]);
}

// Takes from the row of a cell what its tree reaches only through cells that do not see it; whether there was any.
// `kept` [largest tree] and `row` [words] are scratch.
static bool trim_row(StabForest *forest, const Tree *tree, int root, unsigned char *kept, uint64_t *row,
                     Arena *scratch) {
    memset(row, 0, (size_t)forest->words * sizeof *row);
    for (int i = 0; i < tree->count; i++) {
        const StabNode *node = &tree->nodes[i];
        kept[i] = (node->parent < 0 || kept[node->parent]) && vis_sees(forest, root, node->cell);
        if (kept[i]) row_add(row, node->cell);
    }
    return cell_rows_keep(&forest->seen, root, row, scratch);
}

// Sight is symmetric, and a cell is seen only through cells that are seen: what contradicts this is dropped until the
// sets and the trees agree.
static void settle_sets(StabForest *forest, const Tree *trees, int largest, Arena *scratch) {
    uint64_t *row = ARENA_ARRAY(scratch, uint64_t, forest->words);
    unsigned char *kept = ARENA_ARRAY(scratch, unsigned char, largest);
    for (bool changed = true; changed;) {
        cell_rows_make_symmetric(&forest->seen, scratch);
        changed = false;
        for (int c = 0; c < forest->cell_count; c++) {
            if (!trees[c].bounded) changed = trim_row(forest, &trees[c], c, kept, row, scratch) || changed;
        }
    }
}

// Appends what is left of a tree when the cells that do not see its root are cut off.
static void append_tree(StabForest *forest, const Tree *tree, int root, int *renumber) {
    int base = forest->root[root], kept = 0;
    for (int i = 0; i < tree->count; i++) {
        StabNode node = tree->nodes[i];
        bool keep = (node.parent < 0 || renumber[node.parent] >= 0) && vis_sees(forest, root, node.cell);
        renumber[i] = keep ? kept : -1;
        if (!keep) continue;
        if (node.parent >= 0) node.parent = base + renumber[node.parent];
        forest->nodes[base + kept++] = node;
    }
    forest->root[root + 1] = base + kept;
}

// Links siblings anew: nodes are in depth-first order, so a node's next sibling is the next one with its parent.
static void link_siblings(StabForest *forest, int root, int *last) {
    for (int i = forest->root[root]; i < forest->root[root + 1]; i++) {
        StabNode *node = &forest->nodes[i];
        node->next = -1;
        last[i - forest->root[root]] = -1;
        if (node->parent < 0) continue;
        int *previous = &last[node->parent - forest->root[root]];
        if (*previous >= 0) forest->nodes[*previous].next = i;
        *previous = i;
    }
}

static void assemble(StabForest *forest, const Tree *trees, Arena *arena, Arena *scratch) {
    int total = 0, largest = 1;
    for (int c = 0; c < forest->cell_count; c++) {
        total += trees[c].count;
        if (trees[c].count > largest) largest = trees[c].count;
    }
    settle_sets(forest, trees, largest, scratch);
    forest->nodes = ARENA_ARRAY(arena, StabNode, total);
    int *scrap = ARENA_ARRAY(scratch, int, largest);
    for (int c = 0; c < forest->cell_count; c++) {
        forest->bounded[c] = trees[c].bounded;
        append_tree(forest, &trees[c], c, scrap);
        link_siblings(forest, c, scrap);
    }
    forest->node_count = forest->root[forest->cell_count];
}

bool vis_build_forest(const CellGraph *graph, const VisOptions *options, const Progress *progress,
                      Arena *arena, StabForest *out) {
    Arena scratch = {0};
    int count = graph->cell_count;
    *out = (StabForest){.cell_count = count, .words = (count + 63) / 64};
    out->root = ARENA_ARRAY(arena, int, count + 1);
    out->bounded = ARENA_ARRAY(arena, unsigned char, count);
    out->seen = cell_rows_new(count, &scratch);
    Growth growth = {.forest = out,
                     .trees = ARENA_ARRAY(&scratch, Tree, count),
                     .progress = progress,
                     .lock = PTHREAD_MUTEX_INITIALIZER};
    int threads = parallel_threads(options->threads);
    grow_all(&growth, tree_source_new(graph, options, &scratch), threads, &scratch);
    if (!growth.stopped) assemble(out, growth.trees, arena, &scratch);
    out->seen = cell_rows_copy(&out->seen, arena);
    for (int i = 0; i < threads; i++) arena_free(&growth.own[i]);
    for (int c = 0; c < count; c++) memory_free(growth.trees[c].nodes);
    arena_free(&scratch);
    return !growth.stopped;
}
