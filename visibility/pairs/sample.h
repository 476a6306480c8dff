// sample.h - a lower bound of what cells see of each other: from points on portals, whatever a line through the portals
// ahead still reaches. The oracle of the methods: it shares nothing with them, and each pair it finds is walked again
// (witness.h) before it counts.
#ifndef VISIBILITY_PAIRS_SAMPLE_H
#define VISIBILITY_PAIRS_SAMPLE_H

#include "visibility/pairs/pairs.h"

typedef struct SampleOptions {
    int threads;  // 0: all cores; the result is the same on any number
    int points;   // on each portal, 1 .. SAMPLE_MOST_POINTS; and as many eyes inside each cell
    uint64_t seed;
} SampleOptions;
enum { SAMPLE_MOST_POINTS = 1000000 };
SampleOptions sample_default_options(void);

typedef struct SampleSet {
    int cell_count, words;
    uint64_t *proven;   // [cell_count * words] as PairSet.proven: symmetric, diagonal set
    long long windows;  // portals that were looked through, each time one was
    long long refuted;  // candidates that did not stand the second walk: too near an edge, or too flat
    bool stopped;       // progress asked to stop: `proven` holds the pairs found until then
} SampleSet;

void sample_pairs(const CellGraph *graph, const SampleOptions *options, const Progress *progress,
                  Arena *arena, SampleSet *out);

// A sightline from cell a to cell b among those that sample_pairs finds from a; false where there is none.
bool sample_sightline(const CellGraph *graph, const SampleOptions *options, int a, int b, PairWitness *out);

#endif
