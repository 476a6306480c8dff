// height.c - the method `height`: a line in plan crosses all portals on the way, and one slope fits all their heights.
// Two and a half dimensions: what is bounded in plan and in height apart is not bounded together.
#include "visibility/pairs/plan_search.h"

static void find(const CellGraph *graph, const PairOptions *options, const Progress *progress, Arena *arena,
                 PairSet *out) {
    plan_search(graph, true, options, progress, arena, out);
}

const PairMethod PAIR_METHOD_HEIGHT = {
    .name = "height", .summary = "a line in plan, and one slope that fits the heights", .find = find};
