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

// The pairs that the method `proof` finds: of a large building group of cells by group, else in one matrix. False, without a result,
// where the building has more than VIS_MANY_CELLS and is so open that windows do not pay (window.h), or progress asked to stop before
// that was known.
bool campus_pairs(const CellGraph *graph, const PairOptions *options, const Progress *progress, Arena *arena,
                  CampusPairs *out);

#endif
