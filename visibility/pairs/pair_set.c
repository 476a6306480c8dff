// pair_set.c - sets of pairs as methods fill them.
#include "visibility/pairs/pairs.h"

PairSet pair_set_new(const CellGraph *graph, Arena *arena) {
    PairSet set = {.cell_count = graph->cell_count, .words = (graph->cell_count + 63) / 64};
    size_t size = (size_t)set.cell_count * (size_t)set.words;
    set.seen = ARENA_ARRAY(arena, uint64_t, size);
    set.proven = ARENA_ARRAY(arena, uint64_t, size);
    return set;
}

static void set_bit(uint64_t *rows, int words, int from, int to, bool value) {
    uint64_t *word = &rows[(size_t)from * (size_t)words + (size_t)to / 64], bit = (uint64_t)1 << (to % 64);
    *word = value ? *word | bit : *word & ~bit;
}

void pair_set_take_known(PairSet *set, const PairSet *known) {
    for (size_t i = 0; i < (size_t)set->cell_count * (size_t)set->words; i++) {
        set->seen[i] &= known->seen[i];
        set->proven[i] |= known->proven[i];
    }
}

void pair_set_make_symmetric(PairSet *set) {
    int words = set->words;
    for (int i = 0; i < set->cell_count; i++) {
        set_bit(set->seen, words, i, i, true);
        set_bit(set->proven, words, i, i, true);
        for (int j = 0; j < i; j++) {
            bool seen = pair_bit(set->seen, words, i, j) && pair_bit(set->seen, words, j, i);
            bool proven = pair_bit(set->proven, words, i, j) || pair_bit(set->proven, words, j, i);
            set_bit(set->seen, words, i, j, seen);
            set_bit(set->seen, words, j, i, seen);
            set_bit(set->proven, words, i, j, proven);
            set_bit(set->proven, words, j, i, proven);
        }
    }
}

long long pair_count(const uint64_t *rows, int cell_count, int words) {
    long long count = 0;
    for (size_t i = 0; i < (size_t)cell_count * (size_t)words; i++) count += __builtin_popcountll(rows[i]);
    return count;
}

void chain_work_add(ChainWork *to, ChainWork from) {
    to->chains += from.chains;
    to->clips += from.clips;
    to->separators += from.separators;
    to->given_up += from.given_up;
}
