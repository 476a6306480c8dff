// proof.c - the method `proof`: every pair is excluded by separating planes or proven by a sightline, but for the few
// that rounding or the patience of settle.c leave open.
//
// Lines are cast first, and tried wherever a search comes upon a cell in doubt. A line proves all pairs of the cells on its way at
// once, and proven cells are not looked for again: most of the work that is left goes into cells that are truly hidden. Most of
// these are excluded by the merged search (merged.h), whose time does not grow with the number of chains; the search along chains,
// which is finer, has only the rest to decide, and settle.c what that leaves.
#include "visibility/pairs/proof.h"

#include "visibility/pairs/cast.h"
#include "visibility/pairs/merged.h"
#include "visibility/pairs/settle.h"
#include "visibility/pairs/sight.h"

static void try_line(Flow *flow, int depth) {
    enum { WORK_SIGHT = 500 };  // a portal, see ways_work
    flow->spent += WORK_SIGHT * (depth + 1);
    Sight sight;
    if (sight_through(flow, depth, &flow->steps[depth]->beam.source, &sight)) {
        sight_record(flow, depth, sight);
        return;
    }
    int cell = flow_cell(flow, depth);
    row_add(((Finding *)flow->context)->kept, cell);
    row_drop(flow->unknown, cell);
}

static void seen(Flow *flow, int depth) {
    Sight sight;
    if (sight_to_middle(flow, depth, flow->point, &sight)) sight_record(flow, depth, sight);
}

// Where much is in doubt a look from the middle of the portal decides most of it.
static void look_from_middle(Flow *flow, int way) {
    enum { MUCH = 32 };
    int doubts = 0;
    for (int i = 0; i < flow->ways->words; i++) doubts += __builtin_popcountll(flow->unknown[i]);
    if (doubts >= MUCH) {
        flow->point = flow->ways->ways[way].facet.middle;
        flow_look(flow, way, seen);
    }
}

static bool search_chains(Flow *flow, int way) {
    look_from_middle(flow, way);
    return flow_search(flow, way);
}

static bool search_merged(Flow *flow, int way) {
    look_from_middle(flow, way);
    return merged_search(flow, way);
}

// Neighbours see each other through the middle of their portal.
static void prove_neighbours(Rounds *r) {
    for (int i = 0; i < r->ways.way_count; i += 2) {
        const WayShape *way = &r->ways.ways[i];
        Vec3 step = vec3_scale(way->facet.plane.n, r->ways.epsilon);
        Sight across = {vec3_sub(way->facet.middle, step), vec3_add(way->facet.middle, step)};
        if (way->coarse || !sight_passes(way, across, r->ways.epsilon)) continue;  // a hair's breadth wide
        bool turn = way->from > way->to;
        PairEnds pair = turn ? (PairEnds){way->to, way->from} : (PairEnds){way->from, way->to};
        Sight line = turn ? (Sight){across.to, across.from} : across;
        rounds_prove(r, &pair, &line, 1);
    }
}

// Its time is polynomial: it may go on to the end.
static const double WORK_MERGED = 6e9;

void proof_search(Rounds *r, bool reach) {
    Cast cast;
    cast_build(&r->ways, r->scratch, &cast);
    r->cast = &cast;
    prove_neighbours(r);
    cast_from_portals(r);
    if (reach) rounds_reach(r);
    if (!r->stopped) rounds_search(r, WORK_MERGED, search_merged, NULL);
    if (!r->stopped) rounds_search(r, ROUNDS_WORK, search_chains, try_line);
    if (!r->stopped) settle_pairs(r);
    rounds_end(r);
}

static void proof_find(const CellGraph *graph, const PairOptions *options, const Progress *progress,
                       Arena *arena, PairSet *out) {
    Rounds rounds;
    rounds_start(&rounds, graph, options, progress, arena, out);
    proof_search(&rounds, true);
}

const PairMethod PAIR_METHOD_PROOF = {.name = "proof",
                                      .summary =
                                          "separating planes against sightlines, until one of them wins",
                                      .find = proof_find};
