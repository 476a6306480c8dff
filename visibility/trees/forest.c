// forest.c - the stab trees of all cells, and who sees whom.
//
// Cells are independent of each other, so the threads do not show in the result. Visibility is symmetric: the sets
// are intersected with their transpose, and the trees cut accordingly. A cell that has more sequences than allowed keeps
// no tree, and the cells that may be seen as the caller knows are its visible set.
#include <pthread.h>
#include <string.h>

#include "engine/core/memory.h"
#include "engine/core/parallel.h"
#include "visibility/beam.h"
#include "visibility/sightline.h"
#include "visibility/vis.h"
#include "visibility/ways.h"
#include "visibility/window.h"

// The data from which all trees of a building are grown; read only, on any number of threads.
typedef struct TreeSource TreeSource;

typedef struct Tree {
    StabNode *nodes;  // malloc'd; of this tree alone, depth-first, numbered from 0
    int count;
    bool bounded;
    long long spent;  // work
} Tree;

// The data with which one thread grows trees.
typedef struct TreeGrower TreeGrower;

// ---- the stab tree of one cell: depth-first through portals while a sightline crosses the whole sequence
// (Teller & Sequin 1991).
//
// A sequence stays in the tree as long as all tests pass, the cheapest first. Each errs towards visible.
//   1. Every two cells on the way may see each other as the caller knows: the line passes through both. Where he knows
//      nothing, a flood through the first portal reaches the cell (ways_flood); in a building of many cells, the test is left out.
//   2. A line that goes up through a level portal never comes down through another.
//   3. A line in plan crosses all upright portals: exact signs (sightline.h). Others have an area in plan.
//   4. Separating planes in three dimensions leave something of the first portal and of the last (beam.h). Planes between
//      all pairs of portals on the way instead of these would take 1 to 4 % of the nodes for 3 to 10 times the work.
//
// In open buildings there are too many sequences that lines do cross. Such a tree is given up early: depth-first search
// knows which share of all choices it has been through, and so how large the tree will be (P. C. Chen's estimate of 1992,
// without its random choices).

// A way as the plan shows it.
typedef struct GridWay {
    Vec2 left, right;  // as seen when crossing, in whole millimetres where the plan is on the grid
    bool upright;      // else it has an area in plan
    int rise;          // of a level portal: +1 up, -1 down; else 0
} GridWay;

struct TreeSource {
    WayGraph ways;
    GridWay *plan;          // [way_count]
    const uint64_t *known;  // [cell_count * words] the pairs that may see each other, or NULL
    CellWindow window;  // the group of cells whose trees are grown, where pairs are known; else of no cells
    int limit;          // nodes of one tree
    // Nothing is known, and floods from each of VIS_MANY_CELLS would take longer than trees: no test 1
    bool large;
};

// On the grid, whole millimetres make collinear points exactly collinear; off it, points are taken as they are.
static double grid_millimetres(double x) {
    double mm = x / MAPS_GRID;
    return x == maps_snap(x) ? nearbyint(mm) : mm;
}

static Vec2 plan_millimetres(Vec2 p) { return vec2(grid_millimetres(p.x), grid_millimetres(p.y)); }

static GridWay plan_way(const CellGraph *graph, const WayGraph *ways, int way) {
    const Portal *portal = &graph->portals[way / 2];
    bool back = way % 2;
    Vec2 left = plan_millimetres(portal->left), right = plan_millimetres(portal->right);
    bool level = fabs(portal->plane.n.z) == 1;
    return (GridWay){.left = back ? right : left,
                     .right = back ? left : right,
                     .upright = way_is_segment(graph, way, ways->epsilon),
                     .rise = !level                            ? 0
                             : (portal->plane.n.z > 0) == back ? 1
                                                               : -1};
}

// In large buildings each tree may have its share of MOST_NODES only, or as many as a tree of rooms has.
static int tree_limit(const VisOptions *options, int cell_count) {
    enum { MOST_NODES = 8 << 20, OF_ROOMS = 1024 };  // 128 MB
    int share = MOST_NODES / (cell_count > 0 ? cell_count : 1);
    if (share < OF_ROOMS) share = OF_ROOMS;
    return options->max_nodes < share ? options->max_nodes : share;
}

static void tree_source_make(const CellGraph *graph, TreeSource *source, Arena *arena) {
    ways_build(graph, arena, &source->ways);
    source->plan = ARENA_ARRAY(arena, GridWay, source->ways.way_count);
    for (int i = 0; i < source->ways.way_count; i++) source->plan[i] = plan_way(graph, &source->ways, i);
}

// The pairs of a window as a matrix. `list` [cells of the building] is scratch.
static const uint64_t *known_matrix(const CellRows *known, const CellWindow *window, const int *place,
                                    int *list, Arena *arena) {
    int cells = window->graph.cell_count;
    size_t words = ((size_t)cells + 63) / 64;
    uint64_t *matrix = ARENA_ARRAY(arena, uint64_t, (size_t)cells * words);
    for (int c = 0; c < cells; c++) {
        int count = cell_rows_list(known, window->cell[c], list);
        for (int i = 0; i < count; i++)
            if (place[list[i]] >= 0) row_add(matrix + (size_t)c * words, place[list[i]]);
    }
    return matrix;
}

// Where the search stands after one way.
typedef struct Level {
    Beam beam;
    uint64_t *may;  // [words] cells that a line which came so far may enter; NULL: all
    int rise;       // of the last level portal
    bool spread;    // the beam has its planes
    double share;   // of all choices, that lie beyond this way
} Level;

typedef struct TreeGrower Grower;
struct TreeGrower {
    const TreeSource *source;
    StabNode *nodes;  // of memory_grow: it grows in a thread of its own
    int count, capacity;
    Sightline line;
    unsigned char *on_path;  // [cell_count] a straight line enters a convex cell once
    Level **levels;          // [cell_count] levels[0] is after the first way
    double done;             // share of all choices that was decided
    bool exhausted;
    long long spent, allowed;  // see ways_work
    uint64_t *reached, *all;   // [words] of tree_grow
    int *stack;                // [cell_count]
    Arena arena;
};

// The work of steps, see ways_work: a way tried, and each end of a line that is longer than most; one narrowed by planes, and a
// node besides its words.
enum { WORK_WAY = 30, WORK_END = 8, LONG_LINE = 16, WORK_NARROW = 300, WORK_NODE = 100 };
static const double WORK = 6e8;  // of all trees

static Level *level_at(Grower *g, int depth) {
    if (!g->levels[depth]) {
        g->levels[depth] = ARENA_ARRAY(&g->arena, Level, 1);
        if (!g->source->large)
            g->levels[depth]->may = ARENA_ARRAY(&g->arena, uint64_t, g->source->ways.words);
    }
    return g->levels[depth];
}

// Is the tree, by the share of choices decided so far, much too large? From so many nodes on the estimate is seldom so many
// times the truth: of the trees that would fit, those given up were 1 % (dm4), 5 % (e1m1, a Doom map), 14 % (another).
static bool hopeless(const Grower *g) {
    enum { SURE_NODES = 256, FACTOR = 8 };
    return g->count >= SURE_NODES && g->count > FACTOR * g->done * g->source->limit;
}

static int add_tree_cell(Grower *g, int cell, int portal, int parent) {
    g->spent += WORK_NODE + (g->source->large ? 0 : g->source->ways.words);
    if (g->count > 0 && (g->count == g->source->limit || hopeless(g) || g->spent >= g->allowed)) {
        g->exhausted = true;
        return -1;
    }
    if (g->count == g->capacity) {
        g->capacity = g->capacity ? g->capacity * 2 : 256;
        g->nodes = memory_grow(g->nodes, (size_t)g->capacity * sizeof *g->nodes);
    }
    g->nodes[g->count] = (StabNode){cell, portal, parent, -1};
    return g->count++;
}

static void leave(Grower *g, int way, const SightlineUndo *undo) {
    if (g->source->plan[way].upright) sightline_pop(&g->line, undo);
}

// Do separating planes leave something of the portals when the sequence goes on through `way`? The planes behind `from` are
// made when the first way asks for them; where none does they are not needed.
static bool narrow(const Grower *g, Level *from, int way, Level *to) {
    const WayGraph *ways = &g->source->ways;
    Beam *beam = &from->beam;
    if (!from->spread && from != g->levels[0])
        beam_planes(&beam->source, &beam->pass, ways->epsilon, &beam->planes);
    from->spread = true;
    uint64_t cutting;
    ChainWork work = {0};
    if (beam_meets(&ways->ways[way], &beam->planes, ways->epsilon, &cutting) < 0) return false;
    return beam_narrow(ways, &g->levels[0]->beam, beam, way, cutting, &to->beam, &work);
}

// Takes the sequence on through `way`; false when no line crosses it all. Otherwise `leave` takes it back.
static bool cross(Grower *g, Level *from, int way, Level *to, SightlineUndo *undo) {
    const GridWay *plan = &g->source->plan[way];
    int cell = g->source->ways.ways[way].to;
    g->spent += WORK_WAY;
    if (g->on_path[cell] || (from->may && !row_has(from->may, cell)) || from->rise * plan->rise < 0)
        return false;
    if (plan->upright) {
        if (g->line.count > LONG_LINE) g->spent += WORK_END * g->line.count;
        if (!sightline_push(&g->line, plan->left, plan->right, undo)) return false;
    }
    g->spent += WORK_NARROW;
    if (narrow(g, from, way, to)) {
        to->rise = plan->rise ? plan->rise : from->rise;
        to->spread = false;
        return true;
    }
    leave(g, way, undo);
    return false;
}

// The cells that a line may enter that may enter `before` and has come into `cell`.
static void narrow_may(const TreeSource *source, const uint64_t *before, int cell, uint64_t *out) {
    int words = source->ways.words;
    if (source->large) return;
    memcpy(out, before, (size_t)words * sizeof *out);
    if (!source->known) return;
    const uint64_t *known = source->known + (size_t)cell * (size_t)words;
    for (int k = 0; k < words; k++) out[k] &= known[k];
}

static void grow_tree(Grower *g, int node, int depth) {
    const WayGraph *ways = &g->source->ways;
    int cell = g->nodes[node].cell, last = -1, choices = ways->first[cell + 1] - ways->first[cell] - 1;
    Level *level = g->levels[depth], *next = level_at(g, depth + 1);
    if (choices == 0) g->done += level->share;
    g->on_path[cell] = 1;
    for (int i = ways->first[cell]; i < ways->first[cell + 1] && !g->exhausted; i++) {
        int way = ways->list[i], to = ways->ways[way].to;
        SightlineUndo undo;
        if (g->spent >= g->allowed) g->exhausted = true;
        if (way == (level->beam.way ^ 1)) continue;
        next->share = level->share / choices;
        if (!cross(g, level, way, next, &undo)) {
            g->done += next->share;
            continue;
        }
        int child = add_tree_cell(g, to, way / 2, node);
        if (child >= 0) {
            if (last >= 0) g->nodes[last].next = child;
            last = child;
            narrow_may(g->source, level->may, to, next->may);
            grow_tree(g, child, depth + 1);
        }
        leave(g, way, &undo);
    }
    g->on_path[cell] = 0;
}

// Grows the branch through one way out of the root, within the cells of `reached`.
static void grow_branch(Grower *g, int way, double share, const uint64_t *reached) {
    const GridWay *plan = &g->source->plan[way];
    int to = g->source->ways.ways[way].to;
    SightlineUndo undo;
    if (plan->upright) sightline_push(&g->line, plan->left, plan->right, &undo);
    int child = add_tree_cell(g, to, way / 2, 0);
    if (child >= 0) {
        Level *level = level_at(g, 0);
        beam_begin(&g->source->ways, way, &level->beam);
        level->rise = plan->rise;
        level->share = share;
        narrow_may(g->source, reached, to, level->may);
        grow_tree(g, child, 0);
    }
    leave(g, way, &undo);
}

static TreeGrower *tree_grower_new(const TreeSource *source, Arena *arena) {
    Grower *grower = ARENA_ARRAY(arena, Grower, 1), g = {.source = source};
    size_t most = (size_t)source->ways.cell_count + 1;
    g.line = (Sightline){.left = ARENA_ARRAY(&g.arena, Vec2, most),
                         .right = ARENA_ARRAY(&g.arena, Vec2, most),
                         .capacity = (int)most};
    g.on_path = ARENA_ARRAY(&g.arena, unsigned char, most);
    g.levels = ARENA_ARRAY(&g.arena, Level *, most);
    g.reached = ARENA_ARRAY(&g.arena, uint64_t, source->ways.words);
    g.all = ARENA_ARRAY(&g.arena, uint64_t, source->ways.words);
    g.stack = ARENA_ARRAY(&g.arena, int, most);
    *grower = g;
    return grower;
}

static void tree_grower_end(TreeGrower *grower) { arena_free(&grower->arena); }

// Trees of a large building are small: they take a second, or, where they do not, are given up after few.
static long long tree_work(const TreeSource *source) {
    static const long long LARGE = 3000000000;
    return source->large ? LARGE : ways_work(&source->ways, WORK);
}

// How many times the work of a tree that was given up counts: of a large building, more than its own, so that the rest are soon given up.
static int tree_waste(const TreeSource *source) { return source->large ? 8 : 1; }

// The cells that may be seen through the way before lines are tried: all, where the building is large.
static void reach(Grower *g, int cell, int way) {
    const TreeSource *source = g->source;
    size_t words = (size_t)source->ways.words;
    if (source->large) return;
    if (source->known) {
        memcpy(g->reached, source->known + (size_t)cell * words, words * sizeof *g->reached);
    } else {
        memset(g->reached, 0, words * sizeof *g->reached);
        ways_flood(&source->ways, way, g->reached, g->stack);
    }
    for (size_t k = 0; k < words; k++) g->all[k] |= g->reached[k];
}

// In a large building: the visible set of a cell without a tree.
static void reach_far(Grower *g, int cell) {
    const WayGraph *ways = &g->source->ways;
    int seen = 0;
    for (int i = ways->first[cell]; i < ways->first[cell + 1] && seen < ways->cell_count; i++) {
        memset(g->reached, 0, (size_t)ways->words * sizeof *g->reached);
        ways_flood(ways, ways->list[i], g->reached, g->stack);
        seen = 0;
        for (int k = 0; k < ways->words; k++) seen += __builtin_popcountll(g->all[k] |= g->reached[k]);
    }
}

// Returns the tree of a cell, or the root alone where it is too large or takes more work than `allowed`, and marks in `row`
// [words] the cells that may be seen from it.
static Tree tree_grow(TreeGrower *g, int cell, long long allowed, uint64_t *row) {
    const TreeSource *source = g->source;
    const WayGraph *ways = &source->ways;
    size_t words = (size_t)ways->words;
    int first = ways->first[cell], end = ways->first[cell + 1];
    g->nodes = NULL;
    g->count = g->capacity = 0;
    g->done = 0;
    g->exhausted = false;
    g->spent = 0;
    g->allowed = allowed;
    memset(g->all, 0, words * sizeof *g->all);
    g->on_path[cell] = 1;
    add_tree_cell(g, cell, -1, -1);
    for (int i = first; i < end; i++) {
        reach(g, cell, ways->list[i]);
        if (!g->exhausted) grow_branch(g, ways->list[i], 1.0 / (end - first), g->reached);
    }
    g->on_path[cell] = 0;
    if (g->exhausted) {
        g->count = 1;
        if (source->large) reach_far(g, cell);
        for (size_t k = 0; k < words; k++) row[k] |= g->all[k];
    }
    for (int i = 0; i < g->count; i++) row_add(row, g->nodes[i].cell);
    g->nodes = memory_grow(g->nodes, (size_t)g->count * sizeof *g->nodes);
    return (Tree){g->nodes, g->count, g->exhausted, g->spent};
}

// The data that all threads share.
typedef struct Growth {
    TreeSource *source;
    TreeGrower **growers;  // [threads], as are these
    uint64_t **rows;       // [words] of the cell at hand
    int **lists;           // [cell_count] the same, of the building's cells
    Arena *own;            // of rows that are kept
    StabForest *forest;
    Tree *trees;
    const int *run;     // the cells of this run, as the source numbers them
    long long allowed;  // work for one tree of it
    // Where pairs are known:
    const CellGraph *graph;
    const CellRows *known;
    CellGroups groups;
    int *place, *list;  // [cell_count] of window_enter; -1, and scratch
    int limit;          // of nodes
    const Progress *progress;
    pthread_mutex_t lock;  // of `progress`, `done` and `stopped`
    int done, threads;
    bool stopped;
} Growth;

// A tree of a window becomes one of the building.
static void leave_window(const CellWindow *window, Tree *tree) {
    for (int i = 0; i < tree->count; i++) {
        StabNode *node = &tree->nodes[i];
        node->cell = window->cell[node->cell];
        if (node->portal >= 0) node->portal = window->portal[node->portal];
    }
}

static int cell_of_run(const Growth *growth, int index) {
    const CellWindow *window = &growth->source->window;
    return window->cell ? window->cell[growth->run[index]] : growth->run[index];
}

static void grow_next(void *context, int index, int thread) {
    Growth *growth = context;
    const TreeSource *source = growth->source;
    const CellWindow *window = &source->window;
    pthread_mutex_lock(&growth->lock);
    double done = (double)growth->done++ / growth->forest->cell_count;
    if (!growth->stopped && !progress_report(growth->progress, "stab trees", done)) growth->stopped = true;
    bool stopped = growth->stopped;
    pthread_mutex_unlock(&growth->lock);
    if (stopped) return;
    StabForest *forest = growth->forest;
    uint64_t *row = growth->rows[thread];
    int cell = cell_of_run(growth, index), words = source->ways.words;
    memset(row, 0, (size_t)words * sizeof *row);
    growth->trees[cell] = tree_grow(growth->growers[thread], growth->run[index], growth->allowed, row);
    if (!window->cell) {
        cell_rows_set(&forest->seen, cell, row, &growth->own[thread]);
        return;
    }
    int *list = growth->lists[thread], count = 0;
    for (int k = 0; k < words; k++)
        for (uint64_t bits = row[k]; bits; bits &= bits - 1)
            list[count++] = window->cell[64 * k + __builtin_ctzll(bits)];
    cell_rows_set_list(&forest->seen, cell, list, count, &growth->own[thread]);
    leave_window(window, &growth->trees[cell]);
}

// ---- trees for other processes: the tree, its nodes, the number of cells in the row, these

static size_t packed_size(const Growth *growth, int cell) {
    return sizeof(Tree) + (size_t)growth->trees[cell].count * sizeof(StabNode) +
           (1 + (size_t)cell_rows_size(&growth->forest->seen, cell)) * sizeof(int);
}

// Returns where the next one goes.
static unsigned char *put_tree(const Growth *growth, int cell, unsigned char *at) {
    const Tree *tree = &growth->trees[cell];
    int *list = growth->lists[0], count = cell_rows_list(&growth->forest->seen, cell, list);
    size_t nodes = (size_t)tree->count * sizeof *tree->nodes, cells = (size_t)count * sizeof *list;
    memcpy(at, tree, sizeof *tree);
    if (nodes > 0) memcpy(at + sizeof *tree, tree->nodes, nodes);
    at += sizeof *tree + nodes;
    memcpy(at, &count, sizeof count);
    memcpy(at + sizeof count, list, cells);
    return at + sizeof count + cells;
}

static const unsigned char *take_tree(Growth *growth, int cell, const unsigned char *at) {
    Tree *tree = &growth->trees[cell];
    int *list = growth->lists[0], count;
    memcpy(tree, at, sizeof *tree);
    size_t nodes = (size_t)tree->count * sizeof *tree->nodes;
    tree->nodes = nodes > 0 ? memory_new(nodes) : NULL;
    if (nodes > 0) memcpy(tree->nodes, at + sizeof *tree, nodes);
    at += sizeof *tree + nodes;
    memcpy(&count, at, sizeof count);
    size_t cells = (size_t)count * sizeof *list;
    memcpy(list, at + sizeof count, cells);
    cell_rows_set_list(&growth->forest->seen, cell, list, count, &growth->own[0]);
    return at + sizeof count + cells;
}

static Bytes pack_tree(void *context, int index, Arena *arena) {
    const Growth *growth = context;
    int cell = cell_of_run(growth, index);
    Bytes out = {arena_alloc(arena, packed_size(growth, cell), 1), 0};
    out.size = (size_t)(put_tree(growth, cell, out.data) - out.data);
    return out;
}

static void unpack_tree(void *context, int index, Bytes result) {
    Growth *growth = context;
    take_tree(growth, cell_of_run(growth, index), result.data);
}

static Bytes pack_group(void *context, int group, Arena *arena) {
    const Growth *growth = context;
    const CellGroups *groups = &growth->groups;
    size_t size = 0;
    for (int i = groups->first[group]; i < groups->first[group + 1]; i++)
        size += packed_size(growth, groups->cell[i]);
    Bytes out = {arena_alloc(arena, size, 1), 0};
    unsigned char *at = out.data;
    for (int i = groups->first[group]; i < groups->first[group + 1]; i++)
        at = put_tree(growth, groups->cell[i], at);
    out.size = (size_t)(at - out.data);
    return out;
}

static void unpack_group(void *context, int group, Bytes result) {
    Growth *growth = context;
    const CellGroups *groups = &growth->groups;
    const unsigned char *at = result.data;
    for (int i = groups->first[group]; i < groups->first[group + 1]; i++)
        at = take_tree(growth, groups->cell[i], at);
}

// ---- all trees

// The trees of the cells `list` of the source, by work in proportion to their share of its cells. In runs, so that the nodes of trees
// are counted before the next are grown: one may take much more than its share of what is left, since most take less.
static void grow_cells(Growth *growth, const int *list, int count) {
    enum { RUN = 64, TIMES = 64, MOST = 8 };
    const TreeSource *source = growth->source;
    Arena scratch = {0};
    long long left = (long long)((double)tree_work(source) * count / source->ways.cell_count);
    growth->growers = ARENA_ARRAY(&scratch, TreeGrower *, growth->threads);
    growth->rows = ARENA_ARRAY(&scratch, uint64_t *, growth->threads);
    for (int i = 0; i < growth->threads; i++) {
        growth->growers[i] = tree_grower_new(source, &scratch);
        growth->rows[i] = ARENA_ARRAY(&scratch, uint64_t, source->ways.words);
    }
    for (int first = 0; first < count && !growth->stopped; first += RUN) {
        int run = count - first < RUN ? count - first : RUN;
        long long share = left / (count - first) * TIMES;
        SharedLoop loop = {run, grow_next, pack_tree, unpack_tree, growth};
        growth->allowed = share < left / MOST ? share : left / MOST;
        growth->run = list + first;
        parallel_share(growth->threads, &loop);
        growth->stopped = !parallel_agree(!growth->stopped);
        for (int i = 0; i < run; i++) {
            const Tree *tree = &growth->trees[cell_of_run(growth, i)];
            left -= tree->spent * (tree->bounded ? tree_waste(source) : 1);
        }
    }
    for (int i = 0; i < growth->threads; i++) tree_grower_end(growth->growers[i]);
    arena_free(&scratch);
}

// The trees of a group of cells in the window of all that it may see.
static void grow_group(void *context, int group, int thread) {
    (void)thread;
    Growth *growth = context;
    Arena own = {0};
    TreeSource source = {.limit = growth->limit};
    const int *cells = growth->groups.cell + growth->groups.first[group];
    int count = growth->groups.first[group + 1] - growth->groups.first[group],
        *here = ARENA_ARRAY(&own, int, count);
    if (growth->stopped) return;
    growth->done = growth->groups.first[group];
    window_enter(growth->graph, growth->known, cells, count, growth->place, &own, &source.window);
    tree_source_make(&source.window.graph, &source, &own);
    source.known = known_matrix(growth->known, &source.window, growth->place, growth->list, &own);
    for (int i = 0; i < count; i++) here[i] = growth->place[cells[i]];
    growth->source = &source;
    grow_cells(growth, here, count);
    window_leave(&source.window, growth->place);
    arena_free(&own);
}

// Processes share groups, or, where one group has all cells, those.
static void grow_all(Growth *growth, Arena *scratch) {
    int cells = growth->graph->cell_count;
    growth->place = ARENA_ARRAY(scratch, int, cells);
    growth->list = ARENA_ARRAY(scratch, int, cells);
    for (int c = 0; c < cells; c++) growth->place[c] = -1, growth->list[c] = c;
    if (!growth->known) {
        TreeSource source = {.limit = growth->limit, .large = cells > VIS_MANY_CELLS};
        tree_source_make(growth->graph, &source, scratch);
        growth->source = &source;
        grow_cells(growth, growth->list, cells);
        return;
    }
    growth->groups = cell_groups(growth->graph, window_pays(growth->known) ? WINDOW_GROUP : cells, scratch);
    if (growth->groups.count == 1) {
        grow_group(growth, 0, 0);
        return;
    }
    SharedLoop loop = {growth->groups.count, grow_group, pack_group, unpack_group, growth};
    parallel_share(1, &loop);
    growth->stopped = !parallel_agree(!growth->stopped);
}

// Removes from the row of a cell the cells that its tree reaches only through cells that do not see it; returns whether there was any.
// `kept` [largest tree] and `row` [words], which is 0 before and after, are scratch.
static bool trim_row(StabForest *forest, const Tree *tree, int root, unsigned char *kept, uint64_t *row,
                     Arena *scratch) {
    for (int i = 0; i < tree->count; i++) {
        const StabNode *node = &tree->nodes[i];
        kept[i] = (node->parent < 0 || kept[node->parent]) && vis_sees(forest, root, node->cell);
        if (kept[i]) row_add(row, node->cell);
    }
    bool changed = cell_rows_keep(&forest->seen, root, row, scratch);
    for (int i = 0; i < tree->count; i++) row[tree->nodes[i].cell / 64] = 0;
    return changed;
}

// Sight is symmetric, and a cell is seen only through cells that are seen: pairs that contradict this are dropped until the
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

// Appends the rest of a tree when the cells that do not see its root are cut off.
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

static void assemble(StabForest *forest, Tree *trees, Arena *arena, Arena *scratch) {
    enum { RETURN_CELLS = 32768 };
    int largest = 1, capacity = 0;
    for (int c = 0; c < forest->cell_count; c++)
        if (trees[c].count > largest) largest = trees[c].count;
    settle_sets(forest, trees, largest, scratch);
    int *scrap = ARENA_ARRAY(scratch, int, largest);
    for (int c = 0; c < forest->cell_count; c++) {
        forest->bounded[c] = trees[c].bounded;
        forest->nodes = arena_regrow(arena, forest->nodes, sizeof *forest->nodes, forest->root[c],
                                     forest->root[c] + trees[c].count, &capacity);
        append_tree(forest, &trees[c], c, scrap);
        memory_free(trees[c].nodes);
        trees[c].nodes = NULL;
        // The forest takes as much memory as its trees: it takes the place of those that are in it.
        if ((c + 1) % RETURN_CELLS == 0) memory_return_freed();
        link_siblings(forest, c, scrap);
    }
    forest->node_count = forest->root[forest->cell_count];
    forest->nodes = arena_fit(arena, forest->nodes, sizeof *forest->nodes, forest->node_count, capacity);
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
                     .graph = graph,
                     .known = options->known,
                     .limit = tree_limit(options, count),
                     .progress = progress,
                     .threads = parallel_threads(options->threads),
                     .lock = PTHREAD_MUTEX_INITIALIZER};
    growth.own = ARENA_ARRAY(&scratch, Arena, growth.threads);
    growth.lists = ARENA_ARRAY(&scratch, int *, growth.threads);
    for (int i = 0; i < growth.threads; i++) growth.lists[i] = ARENA_ARRAY(&scratch, int, count);
    grow_all(&growth, &scratch);
    if (!growth.stopped) assemble(out, growth.trees, arena, &scratch);
    out->seen = cell_rows_copy(&out->seen, arena);
    for (int i = 0; i < growth.threads; i++) arena_free(&growth.own[i]);
    for (int c = 0; c < count; c++) memory_free(growth.trees[c].nodes);
    arena_free(&scratch);
    return !growth.stopped;
}
