// test_pairs_file.c - a search that was stopped goes on from its file, and damaged files are refused.
#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/core/file.h"
#include "tests/support/prt_scene.h"
#include "tests/support/support.h"
#include "tests/visibility/pairs/pairs_fixture.h"
#include "visibility/pairs/pairs_file.h"

// Asks to stop when it was asked so many times.
static bool stop_later(void *context, const char *stage, double done) {
    int *left = context;
    (void)stage, (void)done;
    return --*left > 0;
}

static PairSet search(const CellGraph *graph, const PairSet *known, int reports, Arena *arena) {
    PairSet set;
    Progress progress = {stop_later, &reports};
    pair_method_finest()->find(graph, &(PairOptions){.threads = 1, .known = known},
                               reports > 0 ? &progress : NULL, arena, &set);
    return set;
}

// Is each pair of one set in the other?
static bool within(const uint64_t *rows, const uint64_t *others, const PairSet *set) {
    for (size_t i = 0; i < (size_t)set->cell_count * (size_t)set->words; i++) {
        if (rows[i] & ~others[i]) return false;
    }
    return true;
}

// Stopped again and again, after however many reports, a search comes to its end with nothing missing that the whole search proves, and
// nothing more than it was left with.
Test(pairs_file, a_stopped_search_goes_on) {
    Arena arena = {0};
    Random random = {7};
    CellGraph *graph = pairs_rooms_graph(&arena, &random, 4, 3, 2);
    PairSet whole = search(graph, NULL, 0, &arena);
    char *path = arena_format(&arena, "%s/stopped.pairs", support_folder(&arena));
    Error error = {""};
    int stops = 0;
    for (int reports = 1; reports < 400; reports = reports * 2 + 1) {
        PairSet first = search(graph, NULL, reports, &arena), known;
        stops += first.stopped;
        cr_assert(pairs_save(path, graph, &first, &error), "%s", error.text);
        cr_assert(pairs_load(path, graph, &arena, &known, &error), "%s", error.text);
        size_t bytes = (size_t)first.cell_count * (size_t)first.words * sizeof *first.seen;
        cr_expect(memcmp(known.seen, first.seen, bytes) == 0 &&
                  memcmp(known.proven, first.proven, bytes) == 0);
        PairSet last = search(graph, &known, 0, &arena);
        cr_expect(within(last.seen, known.seen, &last) && within(known.proven, last.proven, &last));
        cr_expect(within(whole.proven, last.seen, &last), "after %d reports a pair is missed", reports);
        cr_expect(within(last.proven, whole.seen, &last));
    }
    cr_expect_geq(stops, 3);
    // All that is known is not looked for again.
    PairSet again = search(graph, &whole, 0, &arena);
    cr_expect_lt(again.work.chains, whole.work.chains / 2, "%lld chains after %lld", again.work.chains,
                 whole.work.chains);
    remove(path);
    arena_free(&arena);
}

// Files of other cells, cut, with any byte changed, or with rows that contradict themselves are refused.
Test(pairs_file, faults) {
    Arena arena = {0};
    Random random = {8};
    CellGraph *graph = pairs_rooms_graph(&arena, &random, 2, 2, 1),
              *other = pairs_rooms_graph(&arena, &random, 2, 2, 2);
    PairSet set = search(graph, NULL, 0, &arena), read;
    char *path = arena_format(&arena, "%s/faults.pairs", support_folder(&arena));
    Error error = {""};
    Bytes good;
    cr_assert(pairs_save(path, graph, &set, &error));
    cr_expect(!pairs_load(path, other, &arena, &read, &error) && error.text[0]);
    cr_assert(file_read(path, 1 << 20, &arena, &good, &error));
    for (size_t i = 0; i < good.size; i++) {
        for (int cut = 0; cut < 2; cut++) {
            good.data[i] ^= 1;
            cr_assert(file_write(path, good.data, cut ? i : good.size, &error));
            good.data[i] ^= 1;
            error.text[0] = 0;
            cr_expect(!pairs_load(path, graph, &arena, &read, &error) && error.text[0], "byte %zu", i);
        }
    }
    // A pair that is proven one way only, with a right checksum.
    set.proven[0] ^= (uint64_t)1 << 1;
    set.seen[0] |= (uint64_t)1 << 1;
    cr_assert(pairs_save(path, graph, &set, &error));
    cr_expect(!pairs_load(path, graph, &arena, &read, &error));
    cr_expect(strstr(error.text, "its rows do not hold together"), "%s", error.text);
    remove(path);
    arena_free(&arena);
}
