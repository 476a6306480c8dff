// pairs.h - cell-to-cell visibility: which cells may see which, by several methods. One file a method, one row in the
// table; the command line, the tests and the benchmark iterate the table.
//
// Two cells see each other when a straight line leads from the inside of one through portals into the inside of the
// other, all doors open. Every method errs towards visible only: a pair it leaves out is proven invisible.
#ifndef VISIBILITY_PAIRS_PAIRS_H
#define VISIBILITY_PAIRS_PAIRS_H

#include "visibility/vis.h"

// A sightline from inside cell a to inside cell b (or to a point of its boundary), a < b, metres.
typedef struct PairWitness {
    int a, b;
    Vec3 from, to;
} PairWitness;

// The findings of a method.
// Read only once it is made: any number of threads. It lives in the arena of the call that made it.
typedef struct PairSet {
    int cell_count, words;
    uint64_t *seen;  // [cell_count * words] bit j of row i: j may be seen from i. Symmetric, diagonal set
    uint64_t
        *proven;  // as `seen`, of which it is part: pairs with a sightline; all 0 where the method finds none
    PairWitness *witnesses;  // [witness_count] by a, then b; none unless asked for
    int witness_count;
    bool stopped;  // progress asked to stop: `seen` holds the pairs not excluded until then
    ChainWork work;
} PairSet;

// How pairs are searched.
typedef struct PairOptions {
    int threads;     // 0: all cores; the result is the same on any number
    bool witnesses;  // keep the sightlines that prove pairs visible, where the method finds them
    const PairSet
        *known;  // rows of an earlier search of the same cells, from which this one goes on; NULL: none
} PairOptions;

// Bit `to` of row `from` of a matrix as in PairSet.
static inline bool pair_bit(const uint64_t *rows, int words, int from, int to) {
    return rows[(size_t)from * (size_t)words + (size_t)to / 64] >> (to % 64) & 1;
}

// A method: a row of the table.
typedef struct PairMethod {
    const char *name, *summary;
    void (*find)(const CellGraph *graph, const PairOptions *options, const Progress *progress, Arena *arena,
                 PairSet *out);
} PairMethod;

extern const PairMethod *const PAIR_METHODS[];    // from the coarsest to the finest, ends with NULL
const PairMethod *pair_method(const char *name);  // NULL: there is none of that name
const PairMethod *pair_method_finest(void);       // the last: the one that trees are made with

// For methods: an empty set, and its completion by symmetry (seen and its transpose, proven or its transpose).
PairSet pair_set_new(const CellGraph *graph, Arena *arena);
// Takes over what an earlier search excluded and proved.
void pair_set_take_known(PairSet *set, const PairSet *known);
// Visibility is symmetric: seen is seen both ways, proven one way is proven.
void pair_set_make_symmetric(PairSet *set);

// Adds count by count.
void chain_work_add(ChainWork *to, ChainWork from);
long long pair_count(const uint64_t *rows, int cell_count,
                     int words);  // of all bits, the diagonal among them

#endif
