// compare.h - compares a visible set with the pairs that are proven visible.
#ifndef VISIBILITY_PAIRS_COMPARE_H
#define VISIBILITY_PAIRS_COMPARE_H

#include "visibility/pairs/pairs.h"

// Counts of ordered pairs, each cell with itself among them.
typedef struct PairFigures {
    long long visible, bound;  // pairs in the set; pairs proven visible
    long long beyond;          // in the set, not proven
    long long missed;          // proven, not in the set
    int miss[2];               // the first of them, or -1, -1
} PairFigures;

PairFigures pairs_compare(const uint64_t *seen, const uint64_t *bound, int cell_count);
// The over-estimate: the pairs beyond the bound, in percent of the bound.
double pairs_over(const PairFigures *figures);

// Adds to `bound` the pairs whose sightlines hold when walked again, both ways round. Returns how many did not.
long long pairs_check_witnesses(const CellGraph *graph, const PairSet *set, uint64_t *bound);

// Pairs that see each other both ways: the rows without the bits that their transpose lacks.
void pairs_intersect_transpose(const uint64_t *rows, int cell_count, uint64_t *out);
// Adds the pairs of `rows` to `bound`.
void pairs_unite(const uint64_t *rows, int cell_count, uint64_t *bound);

#endif
