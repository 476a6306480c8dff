// flood.c - the coarsest method: the cells that a flood through open portals reaches, way by way.
#include "visibility/pairs/rounds.h"

static void flood_find(const CellGraph *graph, const PairOptions *options, const Progress *progress,
                       Arena *arena, PairSet *out) {
    Rounds rounds;
    rounds_start(&rounds, graph, options, progress, arena, out);
    rounds_end(&rounds);
}

const PairMethod PAIR_METHOD_FLOOD = {
    .name = "flood", .summary = "through open portals, each beyond the first one", .find = flood_find};
