// pairs_fixture.c - see the header.
#include "tests/visibility/pairs/pairs_fixture.h"

#include <criterion/criterion.h>

#include "tests/support/fixture.h"
#include "tests/support/support.h"
#include "visibility/pairs/compare.h"
#include "visibility/pairs/rounds.h"
#include "visibility/pairs/sample.h"
#include "visibility/ways.h"

PairSet pairs_find(const CellGraph *graph, const PairMethod *method, int threads, const Progress *progress,
                   Arena *arena) {
    PairOptions options = {.threads = threads, .witnesses = true};
    PairSet set;
    method->find(graph, &options, progress, arena, &set);
    return set;
}

bool pairs_sees(const PairSet *set, int a, int b) { return pair_bit(set->seen, set->words, a, b); }

CellGraph *pairs_rooms_graph(Arena *arena, Random *random, int nx, int ny, int storeys) {
    CellGraph *graph = ARENA_ARRAY(arena, CellGraph, 1);
    VisOptions options = vis_default_options();
    Error error = {""};
    Building *building = fixture_rooms(arena, random, nx, ny, storeys);
    cr_assert(vis_build_cells(building, &options, arena, graph, &error), "%s", error.text);
    return graph;
}

SampleSet pairs_sample(const CellGraph *graph, int points, int threads, Arena *arena) {
    SampleOptions options = {.threads = threads, .points = points, .seed = 5};
    SampleSet set;
    sample_pairs(graph, &options, NULL, arena, &set);
    return set;
}

int pairs_asymmetries(const uint64_t *rows, int cells) {
    int words = (cells + 63) / 64, wrong = 0;
    for (int i = 0; i < cells; i++) {
        wrong += !pair_bit(rows, words, i, i);
        for (int j = 0; j < i; j++) wrong += pair_bit(rows, words, i, j) != pair_bit(rows, words, j, i);
    }
    return wrong;
}

void pairs_expect_sound(const CellGraph *graph, const PairMethod *method, const PairSet *set) {
    Arena scratch = {0};
    int cells = graph->cell_count;
    uint64_t *checked = ARENA_ARRAY(&scratch, uint64_t, (size_t)cells * (size_t)set->words);
    cr_expect_eq(pairs_asymmetries(set->seen, cells), 0, "%s: asymmetric", method->name);
    cr_expect_eq(pairs_compare(set->seen, set->proven, cells).missed, 0, "%s: proven, not seen",
                 method->name);
    for (int i = 0; i < set->witness_count; i++) {
        const PairWitness *w = &set->witnesses[i];
        cr_assert(w->a < w->b && (i == 0 || w[-1].a < w->a || (w[-1].a == w->a && w[-1].b < w->b)),
                  "%s: sightline %d of %d and %d is not in order", method->name, i, w->a, w->b);
    }
    cr_expect_eq(pairs_check_witnesses(graph, set, checked), 0, "%s: a sightline does not hold",
                 method->name);
    cr_expect_eq(pairs_compare(set->seen, checked, cells).missed, 0, "%s: a sightline to what is not seen",
                 method->name);
    arena_free(&scratch);
}
