// test_pairs_merged.c - chains that are searched as one, and sightlines in bulk.
#include <criterion/criterion.h>

#include "engine/core/text.h"
#include "maps/maps.h"
#include "tests/support/prt_scene.h"
#include "tests/support/support.h"
#include "tests/visibility/pairs/pairs_fixture.h"
#include "visibility/pairs/cast.h"
#include "visibility/pairs/compare.h"
#include "visibility/pairs/merged.h"

// Room in the open: `side` times `side` cubes of air in two storeys, of which some are solid. Every cube of air is a cell.
static CellGraph *open_graph(Arena *arena, Random *random, int side, double solid) {
    enum { STOREYS = 2, MOST = 32, UNIT = 64 };
    static const int STEPS[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    int cell[MOST + 1][MOST + 1][STOREYS + 1], cells = 0, portals = 0;
    Text lines = {.arena = arena}, text = {.arena = arena};
    memset(cell, -1, sizeof cell);
    for (int x = 0; x < side; x++)
        for (int y = 0; y < side; y++)
            for (int z = 0; z < STOREYS; z++)
                if (random_unit(random) >= solid) cell[x][y][z] = cells++;
    for (int i = 0; i < side * side * STOREYS * 3; i++) {
        int axis = i % 3, z = i / 3 % STOREYS, y = i / 3 / STOREYS % side, x = i / 3 / STOREYS / side;
        const int *step = STEPS[axis];
        int a = cell[x][y][z], b = cell[x + step[0]][y + step[1]][z + step[2]];
        if (a < 0 || b < 0) continue;
        portals++;
        text_append(&lines, "4 %d %d", a, b);
        // Clockwise as seen along the step, so that the normal points into cell a.
        for (int k = 0; k < 4; k++) {
            int at[3] = {x, y, z}, u = (axis + 1) % 3, v = (axis + 2) % 3;
            at[axis]++;
            at[u] += k == 1 || k == 2;
            at[v] += k == 2 || k == 3;
            text_append(&lines, " (%d %d %d )", UNIT * at[0], UNIT * at[1], UNIT * at[2]);
        }
        text_append(&lines, "\n");
    }
    text_append(&text, "PRT1\n%d\n%d\n%s", cells, portals, lines.data);
    return prt_scene(arena, text.data);
}

// By the merged search alone, without and with lines cast before.
static PairSet merged_set(const CellGraph *graph, bool lines, int threads, Arena *arena) {
    PairOptions options = {.threads = threads, .witnesses = true};
    PairSet set;
    Rounds rounds;
    Cast cast;
    rounds_start(&rounds, graph, &options, NULL, arena, &set);
    cast_build(&rounds.ways, rounds.scratch, &cast);
    rounds.cast = &cast;
    if (lines) cast_from_portals(&rounds);
    rounds_search(&rounds, ROUNDS_WORK, merged_search, NULL);
    rounds_end(&rounds);
    return set;
}

static void expect_between(const CellGraph *graph, Arena *arena) {
    PairSet flood = pairs_find(graph, pair_method("flood"), 2, NULL, arena);
    PairSet flow = pairs_find(graph, pair_method("flow"), 2, NULL, arena);
    SampleSet samples = pairs_sample(graph, 6, 2, arena);
    for (int lines = 0; lines < 2; lines++) {
        PairSet set = merged_set(graph, lines, 2, arena);
        PairMethod method = {.name = "merged"};
        pairs_expect_sound(graph, &method, &set);
        cr_expect_eq(pairs_compare(set.seen, samples.proven, graph->cell_count).missed, 0);
        cr_expect_eq(pairs_compare(flood.seen, set.seen, graph->cell_count).missed, 0);
        long long seen = pair_count(set.seen, set.cell_count, set.words),
                  finest = pair_count(flow.seen, flow.cell_count, flow.words),
                  proven = pair_count(set.proven, set.cell_count, set.words);
        cr_expect_leq(seen, finest + finest / 20, "%lld of %lld", seen, finest);
        cr_expect_geq(proven, finest * 8 / 10, "%lld of %lld", proven, finest);
    }
}

// Proves that the merged search misses no pair that has a sightline and sees few more than the search along chains, and that its lines
// hold and prove most pairs; among rooms and in the open.
Test(pairs, merged_chains_err_towards_visible) {
    Random random = {31};
    for (int k = 0; k < support_count(3, 30); k++) {
        Arena arena = {0};
        expect_between(pairs_rooms_graph(&arena, &random, 3, 2, 1 + k % 2), &arena);
        expect_between(open_graph(&arena, &random, 6, 0.3), &arena);
        arena_free(&arena);
    }
}

// Proves that wide open space leaves hardly a pair undecided, in the same bytes on any number of threads.
Test(pairs, the_open_is_decided, .timeout = 300) {
    Arena arena = {0};
    Random random = {32};
    CellGraph *graph = open_graph(&arena, &random, support_count(14, 20), 0.2);
    PairSet one = pairs_find(graph, pair_method("proof"), 1, NULL, &arena),
            two = pairs_find(graph, pair_method("proof"), 2, NULL, &arena);
    long long seen = pair_count(one.seen, one.cell_count, one.words),
              proven = pair_count(one.proven, one.cell_count, one.words);
    cr_expect_leq(seen - proven, seen / 100, "%lld of %lld undecided", seen - proven, seen);
    cr_expect_eq(pairs_compare(one.seen, two.seen, graph->cell_count).missed, 0);
    cr_expect_eq(one.witness_count, two.witness_count);
    pairs_expect_sound(graph, pair_method("proof"), &one);
    arena_free(&arena);
}

// Proves that a portal file tells its size, by which searches are allowed to work.
Test(pairs, a_portal_file_has_a_size) {
    Arena arena = {0};
    Building building;
    Error error = {""};
    const char *path = prt_file(&arena, "lqdm2_omitdetail", "build/maps/hillside.sh3d");
    cr_assert(maps_read(path, &arena, &building, &error), "%s", error.text);
    cr_expect_gt(building.file_size, 1000);
    arena_free(&arena);
}
