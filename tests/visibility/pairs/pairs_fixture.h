// pairs_fixture.h - graphs of cells and searches of their pairs, and what must hold of every result.
#ifndef TESTS_PAIRS_FIXTURE_H
#define TESTS_PAIRS_FIXTURE_H

#include "tests/support/prt_scene.h"
#include "tests/support/support.h"
#include "visibility/pairs/rounds.h"
#include "visibility/pairs/sample.h"

PairSet pairs_find(const CellGraph *graph, const PairMethod *method, int threads, const Progress *progress,
                   Arena *arena);

bool pairs_sees(const PairSet *set, int a, int b);

CellGraph *pairs_rooms_graph(Arena *arena, Random *random, int nx, int ny, int storeys);

SampleSet pairs_sample(const CellGraph *graph, int points, int threads, Arena *arena);

// Rows whose transpose differs, or in which a cell is missing itself.
int pairs_asymmetries(const uint64_t *rows, int cells);

// Every result is sound: symmetric; a proven pair is a seen one; all witnesses stand the second walk, and come once a pair in order.
void pairs_expect_sound(const CellGraph *graph, const PairMethod *method, const PairSet *set);

#endif
