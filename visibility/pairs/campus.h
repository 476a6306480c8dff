// campus.h - all pairs of a building of any number of cells, at a cost that grows with the pairs that see each other, not with all.
#ifndef VISIBILITY_PAIRS_CAMPUS_H
#define VISIBILITY_PAIRS_CAMPUS_H

#include "visibility/pairs/pairs.h"

typedef struct CampusPairs {
    CellRows seen;        // the cells that each cell may see; symmetric, each sees itself
    long long undecided;  // ordered pairs of it without a sightline
    ChainWork work;
    bool stopped;  // progress asked to stop: `seen` holds the pairs not excluded until then
} CampusPairs;

// What the method `proof` finds, group of cells by group. False, without a result, where the building is so open that most cells see
// hundreds of others and the first bounds take too long, or when progress asked to stop before these were there.
bool campus_pairs(const CellGraph *graph, const PairOptions *options, const Progress *progress, Arena *arena,
                  CampusPairs *out);

#endif
