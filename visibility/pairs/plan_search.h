// plan_search.h - depth-first through portals while a line in plan crosses them all: what `plan` and `height` share.
#ifndef VISIBILITY_PAIRS_PLAN_SEARCH_H
#define VISIBILITY_PAIRS_PLAN_SEARCH_H

#include "visibility/pairs/pairs.h"

// As PairMethod.find. With `heights` a sequence must besides leave one slope open to the line.
void plan_search(const CellGraph *graph, bool heights, const PairOptions *options, const Progress *progress,
                 Arena *arena, PairSet *out);

#endif
