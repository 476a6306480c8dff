// test_trees.c - stab trees in three dimensions: they hold every sequence of portals that a line crosses, and where heights
// part what the plan shows together, they leave it out.
#include <criterion/criterion.h>

#include "engine/core/memory.h"
#include "maps/maps.h"
#include "tests/support/files/hostile.h"
#include "tests/support/prt_scene.h"
#include "tests/support/support.h"
#include "tests/visibility/trees_fixture.h"
#include "visibility/pairs/pairs.h"

static void read_cells(const char *path, Grown *g) {
    Error error;
    VisOptions options = vis_default_options();
    *g = (Grown){.arena = {0}};
    cr_assert(maps_read(path, &g->arena, &g->building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&g->building, &options, &g->arena, &g->graph, &error), "%s", error.text);
    pair_method_finest()->find(&g->graph, &(PairOptions){0}, NULL, &g->arena, &g->set);
}

static void check_lines(const char *path, bool known) {
    Grown g;
    Lines lines = {0};
    Random random = {9};
    read_cells(path, &g);
    trees_grow(&g, 0, known);
    trees_expect_settled(&g.forest);
    for (int i = 0; i < support_count(1000, 50000); i++) {
        int cell = random_index(&random, g.graph.cell_count);
        if (g.graph.cells[cell].way_count > 0) trees_walk_lines(path, &g, cell, &random, &lines);
    }
    cr_expect(lines.far > 500, "%s: %ld lines, %ld through five portals or more", path, lines.walked,
              lines.far);
    arena_free(&g.arena);
}

// Proves that no sequence that a line crosses is lost: brute force by lines walked from cell to cell.
Test(trees, hold_every_line_of_plans) {
    check_lines("build/maps/house.plan", true);
    check_lines("build/maps/office.plan", false);
}

Test(trees, hold_every_line_of_portal_files, .timeout = 120) {
    Arena arena = {0};
    const char *small = prt_file(&arena, "lqdm2_omitdetail", "build/maps/hillside.sh3d");
    check_lines(small, true);
    check_lines(small, false);
    check_lines(prt_file(&arena, "dm4", "build/maps/villa.sh3d"), true);
    arena_free(&arena);
}

Test(trees, hold_every_line_of_doom_maps, .timeout = 120) {
    check_lines(support_shared("doom/freedoom_dm18.wad"), true);
}

// Doorways that stand behind each other in plan, the middle one higher than any line through the others: of four rooms the
// first sees the third and not the fourth. With the middle one no higher than the others, it sees them all.
Test(trees, heights_end_a_sequence) {
    for (int high = 0; high < 2; high++) {
        Arena arena = {0};
        Row row = {.room_count = 4, .wall = {64, 128, 192, 256}};
        for (int k = 0; k < 3; k++) row.doorway[k] = (Doorway){{0, 32}, {0, 40}};
        if (high) row.doorway[1] = (Doorway){{0, 32}, {48, 88}};
        VisOptions options = vis_default_options();
        StabForest forest;
        cr_assert(vis_build_forest(row_graph(&arena, &row), &options, NULL, &arena, &forest));
        for (int c = 0; c < 4; c++) cr_expect(!forest.bounded[c]);
        cr_expect(vis_sees(&forest, 0, 2));
        cr_expect_eq(vis_sees(&forest, 0, 3), !high);
        cr_expect_eq(forest.node_count, high ? 14 : 16);
        arena_free(&arena);
    }
}

// The same of random rows, whose visibility is known in whole numbers: what is seen is in the tree, and what is not is
// hardly ever.
Test(trees, know_a_row_of_rooms) {
    Random random = {21};
    int hidden = 0, kept = 0;
    for (int n = 0; n < support_count(300, 5000); n++) {
        Arena arena = {0};
        Row row = row_random(&random, 3 + n % 6);
        VisOptions options = vis_default_options();
        StabForest forest;
        cr_assert(vis_build_forest(row_graph(&arena, &row), &options, NULL, &arena, &forest));
        trees_expect_settled(&forest);
        for (int a = 0; a < row.room_count; a++) {
            for (int b = a + 1; b < row.room_count; b++) {
                RowSight sight = row_sight(&row, a, b, true);
                bool only_heights = sight == ROW_HIDDEN && row_sight(&row, a, b, false) == ROW_SEEN;
                bool in_tree = vis_sees(&forest, a, b);
                cr_assert(sight != ROW_SEEN || in_tree, "seed 21, row %d: room %d sees room %d", n, a, b);
                hidden += only_heights;
                kept += only_heights && in_tree;
            }
        }
        arena_free(&arena);
    }
    cr_expect(hidden > 100 && kept == 0, "%d rows hidden by heights alone, %d of them kept", hidden, kept);
}

// Proves determinism where trees are large, given up and trimmed: the same nodes on 1, 2 and 7 threads.
Test(trees, are_the_same_on_any_number_of_threads, .timeout = 120) {
    static const int THREADS[] = {1, 7, 2};
    Grown g;
    Arena arena = {0};
    read_cells(prt_file(&arena, "dm4", "build/maps/villa.sh3d"), &g);
    StabForest first = {0};
    for (int i = 0; i < support_count(2, 3); i++) {
        trees_grow(&g, THREADS[i], true);
        if (i == 0) first = g.forest;
        cr_assert_eq(g.forest.node_count, first.node_count);
        cr_expect_eq(memcmp(g.forest.nodes, first.nodes, sizeof *first.nodes * (size_t)first.node_count), 0);
        cr_expect_eq(memcmp(g.forest.bounded, first.bounded, (size_t)first.cell_count), 0);
        cr_expect(cell_rows_equal(&g.forest.seen, &first.seen));
    }
    arena_free(&arena);
    arena_free(&g.arena);
}
