// flow.c - the method `flow`: three-dimensional separating planes alone. Cells that they leave are called visible; nothing is
// proven.
#include "visibility/pairs/rounds.h"

static void keep_cell(Flow *flow, int depth) {
    int cell = flow_cell(flow, depth);
    row_add(((Finding *)flow->context)->kept, cell);
    row_drop(flow->unknown, cell);
}

static void flow_find(const CellGraph *graph, const PairOptions *options, const Progress *progress,
                      Arena *arena, PairSet *out) {
    Rounds rounds;
    rounds_start(&rounds, graph, options, progress, arena, out);
    rounds_reach(&rounds);
    rounds_search(&rounds, ROUNDS_WORK, flow_search, keep_cell);
    rounds_end(&rounds);
}

const PairMethod PAIR_METHOD_FLOW = {
    .name = "flow", .summary = "separating planes in three dimensions", .find = flow_find};
