// plan.c - the methods `plan` and `height`: which cells a cell may see by its plan: sequences of portals that one line crosses in
// plan (Teller & Sequin 1991, section 4), decided by exact signs of given points, and the slopes that their heights leave open.
//
// An upright portal is a segment in plan, which the line crosses. Any other projects to an area and constrains nothing
// there; nor does an upright one whose corners do not lie on one segment.
//
// Slopes. Let a line cross portals i and then j at heights z_i, z_j, a plan distance d apart, d_least <= d <= d_most. It
// climbs at the slope k = (z_j - z_i) / d, and
//     low_j - high_i <= z_j - z_i <= high_j - low_i,
// so k is at most (high_j - low_i) / d_least where that height is positive, and at most (high_j - low_i) / d_most where
// it is not, since dividing a negative number by more brings it nearer to zero; at least, likewise with low_j - high_i.
// A straight line has one slope, which lies in the intervals of all pairs of its portals. Where these have no common
// slope there is no line: dropped cells are hidden. Where they have one there need not be a line, as each pair may owe
// its bound to another line: the test errs towards visible. d is bounded by the plan boxes of the portals. Heights and
// distances are widened by WayGraph.epsilon, a million times their rounding error.
//
// The search from a cell stays within the flood through its first portal and leaves a branch in which nothing new can be
// reached, by the flood through its last. A cell with too many sequences keeps all cells that the floods reach.
#include <omp.h>

#include "visibility/pairs/pairs.h"
#include "visibility/sightline.h"
#include "visibility/ways.h"

// Tried from one cell: some seconds at most over a large map, and not reached in plans of homes and offices.
enum { MOST_SEQUENCES = 50000 };

typedef struct WayInPlan {
    bool upright;
    Vec2 left, right;  // of an upright one, as seen when crossing: as given, so that signs are exact
    Box box;
} WayInPlan;

typedef struct Slopes {
    double least, most;
} Slopes;

// The data that searches from all cells share.
typedef struct PlanGraph {
    WayGraph ways;
    WayInPlan *plan;  // [way_count]
    uint64_t *flood;  // [way_count * words] cells that a flood through the way reaches
    bool heights;
} PlanGraph;

// One thread's search from one cell.
typedef struct Search {
    const PlanGraph *graph;
    uint64_t *row;          // of the cell: the cells that were reached
    const uint64_t *bound;  // the flood through the first way
    Sightline line;
    int *path;         // [cell_count] ways, from the first on
    Slopes *slopes;    // [cell_count] open after each
    uint64_t *wanted;  // [cell_count * words] the cells that a branch may still add
    unsigned char *on_path;
    long long sequences, limit;
} Search;

static const uint64_t *flood_of(const PlanGraph *graph, int way) {
    return graph->flood + (size_t)way * (size_t)graph->ways.words;
}

static void make_plan(const CellGraph *graph, Arena *scratch, PlanGraph *out) {
    ways_build(graph, scratch, &out->ways);
    out->plan = ARENA_ARRAY(scratch, WayInPlan, out->ways.way_count);
    for (int i = 0; i < out->ways.way_count; i++) {
        const Portal *portal = &graph->portals[i / 2];
        WayInPlan *plan = &out->plan[i];
        *plan = (WayInPlan){way_is_segment(graph, i, out->ways.epsilon), portal->left, portal->right,
                            box_empty()};
        if (i % 2) plan->left = portal->right, plan->right = portal->left;
        const Vec3 *v = graph->portal_vertices + portal->first_vertex;
        for (int k = 0; k < portal->vertex_count; k++) plan->box = box_add(plan->box, v[k]);
    }
}

static double gap(double low_a, double high_a, double low_b, double high_b) {
    return fmax(0, fmax(low_b - high_a, low_a - high_b));
}
static double span(double low_a, double high_a, double low_b, double high_b) {
    return fmax(high_b - low_a, high_a - low_b);
}

// The slopes at which a line may cross one portal and then the other.
static Slopes slopes_between(const Box *a, const Box *b, double epsilon) {
    double x = gap(a->min.x, a->max.x, b->min.x, b->max.x), y = gap(a->min.y, a->max.y, b->min.y, b->max.y);
    double wide = span(a->min.x, a->max.x, b->min.x, b->max.x),
           deep = span(a->min.y, a->max.y, b->min.y, b->max.y);
    double least = fmax(0, sqrt(x * x + y * y) - epsilon), most = sqrt(wide * wide + deep * deep) + epsilon;
    double down = b->min.z - a->max.z - epsilon, up = b->max.z - a->min.z + epsilon;
    // Over no distance at all any slope of that sign will do.
    return (Slopes){down > 0    ? down / most
                    : least > 0 ? down / least
                                : -INFINITY,
                    up < 0      ? up / most
                    : least > 0 ? up / least
                                : INFINITY};
}

// The slopes left open once `way` follows the path so far.
static bool narrow_slopes(Search *s, int depth, int way) {
    const PlanGraph *graph = s->graph;
    Slopes open = depth > 0 ? s->slopes[depth - 1] : (Slopes){-INFINITY, INFINITY};
    for (int i = 0; graph->heights && i < depth && open.least <= open.most; i++) {
        Slopes pair =
            slopes_between(&graph->plan[s->path[i]].box, &graph->plan[way].box, graph->ways.epsilon);
        open = (Slopes){fmax(open.least, pair.least), fmin(open.most, pair.most)};
    }
    s->slopes[depth] = open;
    return open.least <= open.most;
}

// The cells that may be reached through `way` at `depth` and were not yet.
static bool narrow_wanted(Search *s, int depth, int way) {
    int words = s->graph->ways.words;
    uint64_t *out = s->wanted + (size_t)depth * (size_t)words, any = 0;
    const uint64_t *before = depth > 0 ? out - words : s->bound, *flood = flood_of(s->graph, way);
    for (int k = 0; k < words; k++) any |= out[k] = before[k] & flood[k] & ~s->row[k];
    return any != 0;
}

static void follow_sequence(Search *s, int depth, int way);

static void follow_on(Search *s, int depth, int cell) {
    const WayGraph *ways = &s->graph->ways;
    s->on_path[cell] = 1;
    for (int i = ways->first[cell]; i < ways->first[cell + 1] && s->sequences < s->limit; i++) {
        int next = ways->list[i], to = ways->ways[next].to;
        if (!s->on_path[to] && row_has(s->bound, to)) follow_sequence(s, depth + 1, next);
    }
    s->on_path[cell] = 0;
}

static void follow_sequence(Search *s, int depth, int way) {
    const WayInPlan *plan = &s->graph->plan[way];
    SightlineUndo undo;
    if (!narrow_wanted(s, depth, way)) return;
    s->sequences++;
    if (plan->upright && !sightline_push(&s->line, plan->left, plan->right, &undo)) return;
    s->path[depth] = way;
    if (narrow_slopes(s, depth, way)) {
        int cell = s->graph->ways.ways[way].to;
        row_add(s->row, cell);
        follow_on(s, depth, cell);
    }
    if (plan->upright) sightline_pop(&s->line, &undo);
}

static void search_cell(Search *s, int cell, uint64_t *row) {
    const WayGraph *ways = &s->graph->ways;
    s->row = row;
    s->limit = s->sequences + MOST_SEQUENCES;
    s->on_path[cell] = 1;
    row_add(row, cell);
    for (int i = ways->first[cell]; i < ways->first[cell + 1]; i++) {
        s->bound = flood_of(s->graph, ways->list[i]);
        follow_sequence(s, 0, ways->list[i]);
    }
    for (int i = ways->first[cell]; i < ways->first[cell + 1] && s->sequences >= s->limit; i++) {
        const uint64_t *flood = flood_of(s->graph, ways->list[i]);
        for (int k = 0; k < ways->words; k++) row[k] |= flood[k];
    }
    s->on_path[cell] = 0;
}

static Search search_new(const PlanGraph *graph, Arena *arena) {
    size_t cells = (size_t)graph->ways.cell_count + 1;
    return (Search){.graph = graph,
                    .line = {.left = ARENA_ARRAY(arena, Vec2, cells),
                             .right = ARENA_ARRAY(arena, Vec2, cells),
                             .capacity = (int)cells},
                    .path = ARENA_ARRAY(arena, int, cells),
                    .slopes = ARENA_ARRAY(arena, Slopes, cells),
                    .wanted = ARENA_ARRAY(arena, uint64_t, cells * (size_t)graph->ways.words),
                    .on_path = ARENA_ARRAY(arena, unsigned char, cells)};
}

static void flood_all(PlanGraph *graph, Arena *scratch, int threads) {
    const WayGraph *ways = &graph->ways;
    size_t words = (size_t)ways->words;
    graph->flood = ARENA_ARRAY(scratch, uint64_t, (size_t)ways->way_count * words);
#pragma omp parallel num_threads(threads)
    {
        Arena own = {0};
        int *stack = ARENA_ARRAY(&own, int, ways->cell_count);
#pragma omp for schedule(dynamic, 16)
        for (int i = 0; i < ways->way_count; i++)
            ways_flood(ways, i, graph->flood + (size_t)i * words, stack);
        arena_free(&own);
    }
}

// As PairMethod.find. With `heights` a sequence must besides leave one slope open to the line.
static void plan_search(const CellGraph *graph, bool heights, const PairOptions *options,
                        const Progress *progress, Arena *arena, PairSet *out) {
    Arena scratch = {0};
    PlanGraph shared = {.heights = heights};
    int threads = options->threads > 0 ? options->threads : omp_get_num_procs(), done = 0;
    *out = pair_set_new(graph, arena);
    make_plan(graph, &scratch, &shared);
    flood_all(&shared, &scratch, threads);
    bool stopped = false;
    long long sequences = 0;
#pragma omp parallel num_threads(threads) reduction(+ : sequences)
    {
        Arena own = {0};
        Search search = search_new(&shared, &own);
#pragma omp for schedule(dynamic, 1)
        for (int c = 0; c < graph->cell_count; c++) {
            uint64_t *row = out->seen + (size_t)c * (size_t)out->words;
            bool stop;
#pragma omp atomic read
            stop = stopped;
            if (stop) {
                for (int i = 0; i < graph->cell_count; i++) row_add(row, i);
                continue;
            }
            search_cell(&search, c, row);
#pragma omp critical
            if (!progress_report(progress, "plan", (double)++done / graph->cell_count)) {
#pragma omp atomic write
                stopped = true;
            }
        }
        sequences += search.sequences;
        arena_free(&own);
    }
    arena_free(&scratch);
    pair_set_make_symmetric(out);
    out->stopped = stopped;
    out->work.chains = sequences;
}

// A line in plan crosses all portals on the way; their heights are not looked at.
static void plan_find(const CellGraph *graph, const PairOptions *options, const Progress *progress,
                      Arena *arena, PairSet *out) {
    plan_search(graph, false, options, progress, arena, out);
}

const PairMethod PAIR_METHOD_PLAN = {
    .name = "plan", .summary = "a line in plan crosses all portals on the way", .find = plan_find};

// Besides, one slope fits the heights of all portals. Two and a half dimensions: plan and height are bounded apart, not together.
static void height_find(const CellGraph *graph, const PairOptions *options, const Progress *progress,
                        Arena *arena, PairSet *out) {
    plan_search(graph, true, options, progress, arena, out);
}

const PairMethod PAIR_METHOD_HEIGHT = {
    .name = "height", .summary = "a line in plan, and one slope that fits the heights", .find = height_find};
