// plan.c - the method `plan`: a line in plan crosses all portals on the way; their heights are not looked at.
#include "visibility/pairs/plan_search.h"

static void find(const CellGraph *graph, const PairOptions *options, const Progress *progress, Arena *arena,
                 PairSet *out) {
    plan_search(graph, false, options, progress, arena, out);
}

const PairMethod PAIR_METHOD_PLAN = {
    .name = "plan", .summary = "a line in plan crosses all portals on the way", .find = find};
