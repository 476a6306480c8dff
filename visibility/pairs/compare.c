// compare.c - counting sets of pairs against each other.
#include "visibility/pairs/compare.h"

#include "visibility/pairs/witness.h"

static int words_of(int cell_count) { return (cell_count + 63) / 64; }
static void add_bit(uint64_t *rows, int words, int from, int to) {
    rows[(size_t)from * (size_t)words + (size_t)to / 64] |= (uint64_t)1 << (to % 64);
}

PairFigures pairs_compare(const uint64_t *seen, const uint64_t *bound, int cell_count) {
    size_t words = (size_t)words_of(cell_count), size = (size_t)cell_count * words;
    PairFigures f = {.miss = {-1, -1}};
    for (size_t i = 0; i < size; i++) {
        uint64_t missed = bound[i] & ~seen[i];
        f.visible += __builtin_popcountll(seen[i]);
        f.bound += __builtin_popcountll(bound[i]);
        f.beyond += __builtin_popcountll(seen[i] & ~bound[i]);
        f.missed += __builtin_popcountll(missed);
        if (!missed || f.miss[0] >= 0) continue;
        f.miss[0] = (int)(i / words);
        f.miss[1] = (int)(i % words) * 64 + __builtin_ctzll(missed);
    }
    return f;
}

double pairs_over(const PairFigures *figures) {
    return figures->bound > 0 ? 100.0 * (double)figures->beyond / (double)figures->bound : 0;
}

long long pairs_check_witnesses(const CellGraph *graph, const PairSet *set, uint64_t *bound) {
    long long refuted = 0;
    for (int c = 0; c < set->cell_count; c++) add_bit(bound, set->words, c, c);
    for (int i = 0; i < set->witness_count; i++) {
        const PairWitness *w = &set->witnesses[i];
        if (witness_walk(graph, w->a, w->b, w->from, w->to).proves) {
            add_bit(bound, set->words, w->a, w->b);
            add_bit(bound, set->words, w->b, w->a);
        } else {
            refuted++;
        }
    }
    return refuted;
}

void pairs_intersect_transpose(const uint64_t *rows, int cell_count, uint64_t *out) {
    int words = words_of(cell_count);
    memset(out, 0, (size_t)cell_count * (size_t)words * sizeof *out);
    for (int i = 0; i < cell_count; i++) {
        for (int j = 0; j < cell_count; j++) {
            if (pair_bit(rows, words, i, j) && pair_bit(rows, words, j, i)) add_bit(out, words, i, j);
        }
    }
}

void pairs_unite(const uint64_t *rows, int cell_count, uint64_t *bound) {
    for (size_t i = 0; i < (size_t)cell_count * (size_t)words_of(cell_count); i++) bound[i] |= rows[i];
}
