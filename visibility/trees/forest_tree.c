// forest_tree.c - the stab tree of one cell: depth-first through portals while a sightline crosses the whole sequence
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

#include "engine/core/memory.h"
#include "visibility/beam.h"
#include "visibility/sightline.h"
#include "visibility/trees/forest.h"

// A way as the plan shows it.
typedef struct PlanWay {
    Vec2 left, right;  // as seen when crossing, in whole millimetres where the plan is on the grid
    bool upright;      // else it has an area in plan
    int rise;          // of a level portal: +1 up, -1 down; else 0
} PlanWay;

struct TreeSource {
    WayGraph ways;
    PlanWay *plan;          // [way_count]
    const uint64_t *known;  // [cell_count * words] the pairs that may see each other, or NULL
    int limit;              // nodes of one tree
    bool
        large;  // nothing is known, and floods from each of VIS_MANY_CELLS would take longer than trees: no test 1
};

// On the grid, whole millimetres make collinear points exactly collinear; off it, points are taken as they are.
static double grid_millimetres(double x) {
    double mm = x / MAPS_GRID;
    return x == maps_snap(x) ? nearbyint(mm) : mm;
}

static Vec2 plan_millimetres(Vec2 p) { return vec2(grid_millimetres(p.x), grid_millimetres(p.y)); }

static PlanWay plan_way(const CellGraph *graph, const WayGraph *ways, int way) {
    const Portal *portal = &graph->portals[way / 2];
    bool back = way % 2;
    Vec2 left = plan_millimetres(portal->left), right = plan_millimetres(portal->right);
    bool level = fabs(portal->plane.n.z) == 1;
    return (PlanWay){.left = back ? right : left,
                     .right = back ? left : right,
                     .upright = way_is_segment(graph, way, ways->epsilon),
                     .rise = !level                            ? 0
                             : (portal->plane.n.z > 0) == back ? 1
                                                               : -1};
}

// In large buildings each tree may have its share of MOST_NODES only.
static int tree_limit(const VisOptions *options, int cell_count) {
    enum { MOST_NODES = 8 << 20 };  // 128 MB
    int share = MOST_NODES / (cell_count > 0 ? cell_count : 1);
    return options->max_nodes < share ? options->max_nodes : share > 0 ? share : 1;
}

TreeSource *tree_source_new(const CellGraph *graph, const VisOptions *options, Arena *arena) {
    TreeSource *source = ARENA_ARRAY(arena, TreeSource, 1);
    source->known = options->known;
    source->limit = tree_limit(options, graph->cell_count);
    source->large = !source->known && graph->cell_count > VIS_MANY_CELLS;
    ways_build(graph, arena, &source->ways);
    source->plan = ARENA_ARRAY(arena, PlanWay, source->ways.way_count);
    for (int i = 0; i < source->ways.way_count; i++) source->plan[i] = plan_way(graph, &source->ways, i);
    return source;
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
        beam->plane_count = beam_planes(&beam->source, &beam->pass, ways->epsilon, beam->planes);
    from->spread = true;
    uint64_t cutting;
    BeamWork work = {0};
    if (beam_ball(&ways->ways[way], beam->planes, beam->plane_count, &cutting) < 0) return false;
    return beam_narrow(ways, &g->levels[0]->beam, beam, way, cutting, &to->beam, &work);
}

// Takes the sequence on through `way`; false when no line crosses it all. Otherwise `leave` takes it back.
static bool cross(Grower *g, Level *from, int way, Level *to, SightlineUndo *undo) {
    const PlanWay *plan = &g->source->plan[way];
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
    const PlanWay *plan = &g->source->plan[way];
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

TreeGrower *tree_grower_new(const TreeSource *source, Arena *arena) {
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

void tree_grower_end(TreeGrower *grower) { arena_free(&grower->arena); }

// Trees of a large building are small: they take a second, or, where they do not, are given up after few.
long long tree_work(const TreeSource *source) {
    static const long long LARGE = 3000000000;
    return source->large ? LARGE : ways_work(&source->ways, WORK);
}

int tree_waste(const TreeSource *source) { return source->large ? 8 : 1; }

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

// In a large building, what a cell without a tree may see.
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

Tree tree_grow(TreeGrower *g, int cell, long long allowed, uint64_t *row) {
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
