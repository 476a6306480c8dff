// forest.c - the stab tree of every cell: depth-first through portals while a sightline crosses the whole sequence
// (Teller & Sequin 1991).
//
// Upright portals constrain the sightline in plan; others project to an area, and a level one constrains it only in that
// a line which goes up never comes down. Leaving a constraint out errs towards visible. The search stays within the cells
// that may be seen as the caller knows, and else within those that a flood through the first portal reaches, in which
// each further portal must lie at least partly beyond the first one, and the first one before it (in three dimensions).
// A cell that has more sequences than allowed keeps no tree, and these cells are its visible set.
//
// Cells are independent of each other, so the threads do not show in the result. Visibility is symmetric: the sets
// are intersected with their transpose, and the trees cut accordingly.
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/error.h"
#include "engine/core/parallel.h"
#include "visibility/sightline.h"
#include "visibility/vis.h"

typedef struct Step {
    int portal, to;
    Vec2 left, right;  // as seen when crossing, in whole millimetres where the plan is on the grid
    bool upright;      // else it has an area in plan
    int rise;          // of a level portal: +1 up, -1 down; else 0
} Step;

// On the grid, whole millimetres make collinear points exactly collinear; off it, points are taken as they are.
static double grid_millimetres(double x) {
    double mm = x / MAPS_GRID;
    return x == maps_snap(x) ? nearbyint(mm) : mm;
}

static Vec2 plan_millimetres(Vec2 p) { return vec2(grid_millimetres(p.x), grid_millimetres(p.y)); }

static Step *make_steps(const CellGraph *graph, Arena *scratch) {
    Step *steps = ARENA_ARRAY(scratch, Step, graph->contact_count);
    for (int c = 0; c < graph->cell_count; c++) {
        const Cell *cell = &graph->cells[c];
        for (int i = cell->first_contact; i < cell->first_contact + cell->contact_count; i++) {
            const Portal *portal = &graph->portals[graph->contacts[i].portal];
            bool forward = portal->cell[0] == c;
            Vec2 left = plan_millimetres(portal->left), right = plan_millimetres(portal->right);
            bool level = fabs(portal->plane.n.z) == 1;
            steps[i] = (Step){.portal = graph->contacts[i].portal,
                              .to = graph->contacts[i].cell,
                              .left = forward ? left : right,
                              .right = forward ? right : left,
                              .upright = !portal->horizontal,
                              .rise = !level                               ? 0
                                      : (portal->plane.n.z > 0) == forward ? -1
                                                                           : 1};
        }
    }
    return steps;
}

static void mark(uint64_t *row, int cell) { row[cell / 64] |= (uint64_t)1 << (cell % 64); }
static bool marked(const uint64_t *row, int cell) { return row[cell / 64] >> (cell % 64) & 1; }

// One cell's tree while it grows.
typedef struct Grower {
    const CellGraph *graph;
    const Step *steps;
    StabNode *nodes;  // malloc'd: it grows in a thread of its own
    int count, capacity, limit;
    Sightline line;
    unsigned char *on_path;   // [cell_count] a straight line enters a convex cell once
    const uint64_t *reached;  // the cells that the flood through the first portal reaches
    bool exhausted;
} Grower;

static int add_node(Grower *g, int cell, int portal, int parent) {
    if (g->count == g->limit) {
        g->exhausted = true;
        return -1;
    }
    if (g->count == g->capacity) {
        g->capacity = g->capacity ? g->capacity * 2 : 256;
        g->nodes = realloc(g->nodes, (size_t)g->capacity * sizeof *g->nodes);
        CORE_ASSERT(g->nodes);
    }
    g->nodes[g->count] = (StabNode){cell, portal, parent, -1};
    return g->count++;
}

static void grow(Grower *g, int node, int rise) {
    int cell = g->nodes[node].cell, last = -1;
    const Cell *from = &g->graph->cells[cell];
    for (int i = from->first_contact; i < from->first_contact + from->contact_count && !g->exhausted; i++) {
        const Step *step = &g->steps[i];
        if (g->on_path[step->to] || rise * step->rise < 0 || !marked(g->reached, step->to)) continue;
        SightlineUndo undo;
        if (step->upright && !sightline_push(&g->line, step->left, step->right, &undo)) continue;
        int child = add_node(g, step->to, step->portal, node);
        if (child >= 0) {
            if (last >= 0) g->nodes[last].next = child;
            last = child;
            g->on_path[step->to] = 1;
            grow(g, child, step->rise ? step->rise : rise);
            g->on_path[step->to] = 0;
        }
        if (step->upright) sightline_pop(&g->line, &undo);
    }
}

// Does any corner of `what` lie on the given side of `plane` (+1 in front, -1 behind), or on it?
static bool reaches(const CellGraph *graph, const Portal *what, Plane plane, int side) {
    for (int i = 0; i < what->vertex_count; i++) {
        if (side * plane_distance(plane, graph->portal_vertices[what->first_vertex + i]) > -MAPS_GRID)
            return true;
    }
    return false;
}

// The flood through one way out: no line crosses `first` and then `next` unless each lies partly on the far side
// of the other.
static void flood_from(const CellGraph *graph, const Step *steps, int source, int contact, uint64_t *row,
                       int *stack, unsigned char *entered) {
    memset(entered, 0, (size_t)graph->cell_count);
    const Portal *first = &graph->portals[steps[contact].portal];
    int first_side = first->cell[0] == source ? -1 : 1, depth = 0;
    entered[source] = entered[steps[contact].to] = 1;
    mark(row, steps[contact].to);
    stack[depth++] = steps[contact].to;
    while (depth > 0) {
        int cell = stack[--depth];
        const Cell *from = &graph->cells[cell];
        for (int i = from->first_contact; i < from->first_contact + from->contact_count; i++) {
            int to = steps[i].to;
            if (entered[to]) continue;
            const Portal *next = &graph->portals[steps[i].portal];
            int near_side = next->cell[0] == cell ? 1 : -1;
            if (!reaches(graph, next, first->plane, first_side)) continue;
            if (!reaches(graph, first, next->plane, near_side)) continue;
            entered[to] = 1;
            mark(row, to);
            stack[depth++] = to;
        }
    }
}

typedef struct Tree {
    StabNode *nodes;
    int count;
    bool bounded;
} Tree;

// Grows the branch through one way out, within the flood through it.
static void grow_branch(Grower *g, int contact) {
    const Step *step = &g->steps[contact];
    SightlineUndo undo;
    if (step->upright) sightline_push(&g->line, step->left, step->right, &undo);
    int child = add_node(g, step->to, step->portal, 0);
    if (child >= 0) {
        g->on_path[step->to] = 1;
        grow(g, child, step->rise);
        g->on_path[step->to] = 0;
    }
    if (step->upright) sightline_pop(&g->line, &undo);
}

// What all threads share.
typedef struct Growth {
    const CellGraph *graph;
    const Step *steps;
    const uint64_t *known;  // [cell_count * words] the pairs that may see each other, or NULL
    StabForest *forest;
    Tree *trees;
    int limit;  // nodes of one tree
    const Progress *progress;
    pthread_mutex_t lock;  // of `progress`, `done` and `stopped`
    int done;
    bool stopped;
} Growth;

// What may be reached from `source` through each of its ways out: [contact_count * words].
static uint64_t *reach(const Growth *growth, int source, Arena *scratch) {
    const CellGraph *graph = growth->graph;
    const Cell *cell = &graph->cells[source];
    size_t words = (size_t)growth->forest->words;
    uint64_t *reached = ARENA_ARRAY(scratch, uint64_t, words * ((size_t)cell->contact_count + 1));
    int *stack = ARENA_ARRAY(scratch, int, graph->cell_count);
    unsigned char *entered = ARENA_ARRAY(scratch, unsigned char, graph->cell_count);
    for (int i = 0; i < cell->contact_count; i++) {
        uint64_t *row = reached + (size_t)i * words;
        if (growth->known) {
            memcpy(row, growth->known + (size_t)source * words, words * sizeof *row);
        } else {
            flood_from(graph, growth->steps, source, cell->first_contact + i, row, stack, entered);
        }
    }
    return reached;
}

// Writes the visible set of `source` into its row, and returns its tree, or the root alone where that is too large.
static Tree grow_tree(const Growth *growth, int source) {
    const CellGraph *graph = growth->graph;
    size_t most = (size_t)graph->cell_count + 1, words = (size_t)growth->forest->words;
    uint64_t *row = growth->forest->seen + (size_t)source * words;
    Arena scratch = {0};
    Grower g = {.graph = graph,
                .steps = growth->steps,
                .limit = growth->limit,
                .line = {.left = ARENA_ARRAY(&scratch, Vec2, most),
                         .right = ARENA_ARRAY(&scratch, Vec2, most),
                         .capacity = (int)most},
                .on_path = ARENA_ARRAY(&scratch, unsigned char, most)};
    const Cell *cell = &graph->cells[source];
    const uint64_t *reached = reach(growth, source, &scratch);
    g.on_path[source] = 1;
    add_node(&g, source, -1, -1);
    mark(row, source);
    for (int i = 0; i < cell->contact_count && !g.exhausted; i++) {
        g.reached = reached + (size_t)i * words;
        grow_branch(&g, cell->first_contact + i);
    }
    if (g.exhausted) {
        g.count = 1;
        for (size_t i = 0; i < words * (size_t)cell->contact_count; i++) row[i % words] |= reached[i];
    }
    for (int i = 0; i < g.count; i++) mark(row, g.nodes[i].cell);
    arena_free(&scratch);
    return (Tree){g.nodes, g.count, g.exhausted};
}

static void grow_next(void *context, int cell, int thread) {
    Growth *growth = context;
    (void)thread;
    pthread_mutex_lock(&growth->lock);
    double done = (double)growth->done++ / growth->graph->cell_count;
    if (!growth->stopped && !progress_report(growth->progress, "stab trees", done)) growth->stopped = true;
    bool stopped = growth->stopped;
    pthread_mutex_unlock(&growth->lock);
    if (!stopped) growth->trees[cell] = grow_tree(growth, cell);
}

static void make_symmetric(StabForest *forest, uint64_t *transpose) {
    size_t words = (size_t)forest->words, count = (size_t)forest->cell_count;
    memset(transpose, 0, count * words * sizeof *transpose);
    for (int i = 0; i < forest->cell_count; i++) {
        for (size_t k = 0; k < words; k++) {
            for (uint64_t bits = forest->seen[(size_t)i * words + k]; bits; bits &= bits - 1)
                mark(transpose + (k * 64 + (size_t)__builtin_ctzll(bits)) * words, i);
        }
    }
    for (size_t i = 0; i < count * words; i++) forest->seen[i] &= transpose[i];
}

// Takes from the row of a cell what its tree reaches only through cells that do not see it; whether there was any.
// `kept` [largest tree] and `row` [words] are scratch.
static bool trim_row(StabForest *forest, const Tree *tree, int root, unsigned char *kept, uint64_t *row) {
    uint64_t *seen = forest->seen + (size_t)root * (size_t)forest->words, changed = 0;
    memset(row, 0, (size_t)forest->words * sizeof *row);
    for (int i = 0; i < tree->count; i++) {
        const StabNode *node = &tree->nodes[i];
        kept[i] = (node->parent < 0 || kept[node->parent]) && marked(seen, node->cell);
        if (kept[i]) mark(row, node->cell);
    }
    for (int k = 0; k < forest->words; k++) {
        changed |= seen[k] & ~row[k];
        seen[k] &= row[k];
    }
    return changed != 0;
}

// Sight is symmetric, and a cell is seen only through cells that are seen: what contradicts this is dropped until the
// sets and the trees agree.
static void settle_sets(StabForest *forest, const Tree *trees, int largest, Arena *scratch) {
    size_t words = (size_t)forest->words;
    uint64_t *transpose = ARENA_ARRAY(scratch, uint64_t, (size_t)forest->cell_count * words);
    uint64_t *row = ARENA_ARRAY(scratch, uint64_t, words);
    unsigned char *kept = ARENA_ARRAY(scratch, unsigned char, largest);
    for (bool changed = true; changed;) {
        make_symmetric(forest, transpose);
        changed = false;
        for (int c = 0; c < forest->cell_count; c++) {
            if (!trees[c].bounded) changed = trim_row(forest, &trees[c], c, kept, row) || changed;
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

// In large buildings each tree may have its share of MOST_NODES only.
static int tree_limit(const VisOptions *options, int cell_count) {
    enum { MOST_NODES = 8 << 20 };  // 128 MB
    int share = MOST_NODES / (cell_count > 0 ? cell_count : 1);
    return options->max_nodes < share ? options->max_nodes : share > 0 ? share : 1;
}

bool vis_build_forest(const CellGraph *graph, const VisOptions *options, const Progress *progress,
                      Arena *arena, StabForest *out) {
    Arena scratch = {0};
    int count = graph->cell_count;
    *out = (StabForest){.cell_count = count, .words = (count + 63) / 64};
    out->root = ARENA_ARRAY(arena, int, count + 1);
    out->bounded = ARENA_ARRAY(arena, unsigned char, count);
    out->seen = ARENA_ARRAY(arena, uint64_t, (size_t)count * (size_t)out->words);
    Growth growth = {.graph = graph,
                     .steps = make_steps(graph, &scratch),
                     .known = options->known,
                     .forest = out,
                     .trees = ARENA_ARRAY(&scratch, Tree, count),
                     .limit = tree_limit(options, count),
                     .progress = progress,
                     .lock = PTHREAD_MUTEX_INITIALIZER};
    parallel_for(parallel_threads(options->threads), count, grow_next, &growth);
    if (!growth.stopped) assemble(out, growth.trees, arena, &scratch);
    for (int c = 0; c < count; c++) free(growth.trees[c].nodes);
    arena_free(&scratch);
    return !growth.stopped;
}
