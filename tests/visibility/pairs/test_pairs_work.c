// test_pairs_work.c - what pairs cost: samples, threads, searches that are stopped or given up.
#include <criterion/criterion.h>

#include "engine/core/file.h"
#include "tests/support/prt_scene.h"
#include "tests/support/support.h"
#include "tests/visibility/pairs/pairs_fixture.h"
#include "visibility/pairs/compare.h"
#include "visibility/pairs/rounds.h"
#include "visibility/pairs/sample.h"
#include "visibility/pairs/witness.h"
#include "visibility/ways.h"

// The sampler finds nothing that is hidden, and nearly all there is: what it misses is seen through slits only.
Test(pairs, samples_know_a_row_of_rooms) {
    Random random = {12};
    int seen = 0, found = 0;
    for (int k = 0; k < 40; k++) {
        Arena arena = {0};
        Row row = row_random(&random, 4 + k % 6);
        CellGraph *graph = row_graph(&arena, &row);
        SampleSet samples = pairs_sample(graph, 40, 1, &arena);
        cr_expect_eq(pairs_asymmetries(samples.proven, graph->cell_count), 0);
        for (int b = 1; b < row.room_count; b++) {
            for (int a = 0; a < b; a++) {
                bool proven = pair_bit(samples.proven, samples.words, a, b);
                RowSight truth = row_sight(&row, a, b, true);
                cr_expect(!proven || truth == ROW_SEEN, "%d to %d is hidden", a, b);
                seen += truth == ROW_SEEN;
                found += proven;
            }
        }
        arena_free(&arena);
    }
    cr_expect_geq(found, seen * 99 / 100, "%d of %d found", found, seen);
}

static uint64_t hash_of(const PairSet *set) {
    uint64_t hash = file_hash(set->witnesses, (size_t)set->witness_count * sizeof *set->witnesses, 0);
    size_t size = (size_t)set->cell_count * (size_t)set->words * sizeof *set->seen;
    hash = file_hash(set->proven, size, file_hash(set->seen, size, hash));
    return file_hash(&set->work, sizeof set->work, hash);
}

// Pairs, proofs, witnesses and counts of work are the same on 1, 2 and 7 threads; samples too.
Test(pairs, threads_do_not_show) {
    Arena arena = {0};
    Random random = {4};
    CellGraph *graph = pairs_rooms_graph(&arena, &random, 4, 3, 2);
    for (int m = 0; PAIR_METHODS[m]; m++) {
        PairSet one = pairs_find(graph, PAIR_METHODS[m], 1, NULL, &arena);
        for (int threads = 2; threads <= 7; threads += 5) {
            PairSet other = pairs_find(graph, PAIR_METHODS[m], threads, NULL, &arena);
            cr_expect_eq(hash_of(&one), hash_of(&other), "%s on %d threads", PAIR_METHODS[m]->name, threads);
        }
    }
    SampleSet one = pairs_sample(graph, 3, 1, &arena), seven = pairs_sample(graph, 3, 7, &arena);
    size_t size = (size_t)one.cell_count * (size_t)one.words * sizeof *one.proven;
    cr_expect_arr_eq(one.proven, seven.proven, size);
    cr_expect(one.windows == seven.windows && one.refuted == seven.refuted);
    arena_free(&arena);
}

// More points find no less, and another sightline is told for each pair that was found.
Test(pairs, samples_grow_and_can_be_shown) {
    Arena arena = {0};
    Random random = {6};
    CellGraph *graph = pairs_rooms_graph(&arena, &random, 3, 2, 1);
    SampleSet few = pairs_sample(graph, 2, 2, &arena), many = pairs_sample(graph, 12, 2, &arena);
    cr_expect_eq(pairs_compare(many.proven, few.proven, graph->cell_count).missed, 0);
    SampleOptions options = {.points = 2, .seed = 5};
    for (int a = 0; a < graph->cell_count; a++) {
        for (int b = 0; b < graph->cell_count; b++) {
            PairWitness line;
            bool there = sample_sightline(graph, &options, a, b, &line) ||
                         sample_sightline(graph, &options, b, a, &line);
            cr_expect_eq(there, a != b && pair_bit(few.proven, few.words, a, b), "%d and %d", a, b);
            if (there) cr_expect(witness_walk(graph, line.a, line.b, line.from, line.to).proves);
        }
    }
    arena_free(&arena);
}

typedef struct Patience {
    int left;
} Patience;

static bool run_out(void *context, const char *stage, double done) {
    (void)stage, (void)done;
    return ((Patience *)context)->left-- > 0;
}

// Stopped at any report, a method tells so, and what it then calls visible holds all that it would have found; of the
// samples there are only fewer.
Test(pairs, what_is_stopped_errs_towards_visible) {
    Arena arena = {0};
    Random random = {8};
    CellGraph *graph = pairs_rooms_graph(&arena, &random, 3, 3, 1);
    for (int m = 0; PAIR_METHODS[m]; m++) {
        const PairMethod *method = PAIR_METHODS[m];
        PairSet whole = pairs_find(graph, method, 2, NULL, &arena);
        cr_expect_not(whole.stopped, "%s", method->name);
        for (int left = 0; left < 40; left += 1 + left) {
            Patience patience = {left};
            Progress progress = {run_out, &patience};
            PairSet part = pairs_find(graph, method, 2, &progress, &arena);
            cr_expect_eq(part.stopped, patience.left < 0, "%s after %d reports", method->name, left);
            cr_expect_eq(pairs_compare(part.seen, whole.seen, graph->cell_count).missed, 0,
                         "%s after %d reports", method->name, left);
            pairs_expect_sound(graph, method, &part);
        }
    }
    Patience patience = {3};
    Progress progress = {run_out, &patience};
    SampleOptions options = {.threads = 2, .points = 4, .seed = 5};
    SampleSet part, whole = pairs_sample(graph, 4, 2, &arena);
    sample_pairs(graph, &options, &progress, &arena, &part);
    cr_expect(part.stopped);
    cr_expect_eq(pairs_compare(whole.proven, part.proven, graph->cell_count).missed, 0);
    arena_free(&arena);
}

static void arrive(Flow *flow, int depth) {
    int cell = flow_cell(flow, depth);
    row_add(((Finding *)flow->context)->kept, cell);
    row_drop(flow->unknown, cell);
}

// With `scale` times the usual work.
static PairSet search_with(const CellGraph *graph, double scale, Arena *arena) {
    PairOptions options = {.threads = 2};
    PairSet set;
    Rounds rounds;
    rounds_start(&rounds, graph, &options, NULL, arena, &set);
    rounds.ways.scale = scale;
    rounds_search(&rounds, ROUNDS_WORK, flow_search, arrive);
    rounds_end(&rounds);
    return set;
}

// Proves that floods within beams exclude no pair that sees each other, and many that floods alone do not: half of those that do not
// see each other.
Test(pairs, floods_within_beams_exclude_hidden_pairs_only) {
    Arena arena = {0};
    Random random = {21};
    CellGraph *graph = pairs_rooms_graph(&arena, &random, 6, 5, 2);
    PairOptions options = {.threads = 2};
    // Neither of the two goes by beams first.
    SampleSet sample = pairs_sample(graph, 4, 2, &arena);
    PairSet part, flood = pairs_find(graph, pair_method("flood"), 2, NULL, &arena),
                  whole = search_with(graph, 1, &arena);
    Rounds rounds;
    rounds_start(&rounds, graph, &options, NULL, &arena, &part);
    rounds_reach(&rounds);
    rounds_end(&rounds);
    cr_expect_eq(pairs_compare(part.seen, sample.proven, graph->cell_count).missed, 0);
    cr_expect_eq(pairs_compare(flood.seen, part.seen, graph->cell_count).missed, 0);
    cr_expect_eq(pairs_asymmetries(part.seen, graph->cell_count), 0);
    long long all = pair_count(flood.seen, flood.cell_count, flood.words),
              left = pair_count(part.seen, part.cell_count, part.words),
              seen = pair_count(whole.seen, whole.cell_count, whole.words);
    cr_expect_lt(2 * (left - seen), all - seen, "%lld of the flood's %lld are left, %lld are seen", left, all,
                 seen);
    arena_free(&arena);
}

// Proves that searches which may do little work are given up and counted, and that what was in doubt then counts as visible, up to all
// that the flood reaches.
Test(pairs, given_up_errs_towards_visible) {
    Arena arena = {0};
    Random random = {8};
    CellGraph *graph = pairs_rooms_graph(&arena, &random, 4, 4, 1);
    PairSet whole = search_with(graph, 1, &arena), less = whole,
            flood = pairs_find(graph, pair_method("flood"), 2, NULL, &arena);
    cr_expect_eq(whole.work.given_up, 0);
    // A ten-thousandth of the usual work is too little for a few searches, a ten-millionth for any but the easiest.
    for (int k = 4; k < 8; k++) {
        PairSet part = search_with(graph, pow(10, -k), &arena);
        cr_expect(part.work.given_up > 0 && part.work.given_up >= less.work.given_up, "1e-%d: %lld", k,
                  part.work.given_up);
        cr_expect_eq(pairs_compare(part.seen, less.seen, graph->cell_count).missed, 0, "1e-%d", k);
        cr_expect_eq(pairs_compare(flood.seen, part.seen, graph->cell_count).missed, 0, "1e-%d", k);
        cr_expect_eq(pairs_asymmetries(part.seen, graph->cell_count), 0, "1e-%d", k);
        less = part;
    }
    cr_expect_gt(pair_count(less.seen, less.cell_count, less.words),
                 pair_count(whole.seen, whole.cell_count, whole.words));
    arena_free(&arena);
}

// Proves that work grows with the square of a file's size above a megabyte, and is 24 times as much for a map of Doom.
Test(pairs, work_grows_with_the_file) {
    static const struct {
        double size;
        const char *map;
        long long expected;
    } CASES[] = {{0, NULL, 100},     {1, NULL, 100},       {1e6, NULL, 100},    {3e6, NULL, 900},
                 {1e7, NULL, 10000}, {1e5, "MAP01", 2400}, {2e6, "MAP01", 9600}};
    Arena arena = {0};
    Random random = {8};
    CellGraph graph = *pairs_rooms_graph(&arena, &random, 2, 1, 1);
    Building building = *graph.building;
    graph.building = &building;
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        WayGraph ways;
        building.file_size = CASES[i].size;
        building.map = CASES[i].map;
        ways_build(&graph, &arena, &ways);
        cr_expect_eq(ways_work(&ways, 100), CASES[i].expected, "%zu: %lld", i, ways_work(&ways, 100));
    }
    arena_free(&arena);
}

// A graph without portals, and one of a single cell: everybody sees only themselves.
Test(pairs, lonely_cells_see_themselves) {
    Arena arena = {0};
    static const char *const TEXTS[] = {"PRT1\n1\n0\n", "PRT1\n70\n0\n"};
    for (int k = 0; k < 2; k++) {
        CellGraph *graph = prt_scene(&arena, TEXTS[k]);
        for (int c = 0; c < graph->cell_count; c++) {
            Box box = graph->cells[c].box;
            cr_expect(vec3_equal(box.min, box.max) && graph->cells[c].face_count == 0, "it is nowhere");
        }
        for (int m = 0; PAIR_METHODS[m]; m++) {
            PairSet set = pairs_find(graph, PAIR_METHODS[m], 2, NULL, &arena);
            cr_expect_eq(pair_count(set.seen, set.cell_count, set.words), graph->cell_count, "%s",
                         PAIR_METHODS[m]->name);
            pairs_expect_sound(graph, PAIR_METHODS[m], &set);
        }
        SampleSet samples = pairs_sample(graph, 3, 2, &arena);
        cr_expect_eq(pair_count(samples.proven, samples.cell_count, samples.words), graph->cell_count);
    }
    arena_free(&arena);
}

// The table: names differ, each is found by its name, others are not.
Test(pairs, methods_have_names) {
    for (int m = 0; PAIR_METHODS[m]; m++) {
        cr_expect_eq(pair_method(PAIR_METHODS[m]->name), PAIR_METHODS[m]);
        cr_expect_gt(strlen(PAIR_METHODS[m]->summary), 0u);
    }
    cr_expect_null(pair_method("nonsense"));
}
