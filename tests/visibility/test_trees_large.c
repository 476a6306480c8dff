// test_trees_large.c - sets of cells in blocks, and trees of very many cells.
#include <criterion/criterion.h>
#include <stdlib.h>
#include <unistd.h>

#include "engine/core/memory.h"
#include "maps/maps.h"
#include "tests/support/files/hostile.h"
#include "tests/support/support.h"
#include "tests/visibility/trees_fixture.h"
#include "visibility/pairs/pairs.h"

// ---- large buildings

enum { STRETCH = 512, ROW_CELLS = 3 * STRETCH - 100, ROW_WORDS = (ROW_CELLS + 63) / 64 };

static bool dense_has(const uint64_t *rows, int i, int j) {
    return rows[(size_t)i * ROW_WORDS + (size_t)j / 64] >> (j % 64) & 1;
}

static void same_rows(const CellRows *rows, const uint64_t *dense, const char *when) {
    long long count = 0;
    for (int i = 0; i < ROW_CELLS; i++) {
        for (int j = 0; j < ROW_CELLS; j++) {
            cr_assert_eq(cell_rows_has(rows, i, j), dense_has(dense, i, j), "%s: row %d, cell %d", when, i,
                         j);
            count += dense_has(dense, i, j);
        }
    }
    cr_assert_eq(cell_rows_count(rows), count, "%s: the count", when);
}

// Proves that sparse sets are the sets of a matrix of bits through all that is done with them. The first rows hold all
// cells but a few, so that full stretches face full ones and ones with gaps; others hold few cells or none.
Test(cell_rows, hold_what_a_matrix_holds) {
    Arena arena = {0};
    Random random = {11};
    CellRows rows = cell_rows_new(ROW_CELLS, &arena);
    uint64_t *dense = ARENA_ARRAY(&arena, uint64_t, ROW_CELLS * ROW_WORDS),
             *kept = ARENA_ARRAY(&arena, uint64_t, ROW_WORDS);
    for (int i = 0; i < ROW_CELLS; i++) {
        uint64_t *row = dense + (size_t)i * ROW_WORDS;
        bool full = i < STRETCH || i % 7 == 0;
        for (int j = 0; j < ROW_CELLS; j++) {
            bool gap = j % STRETCH == 5 && i % 90 == 3;
            if (full ? !gap : random_index(&random, 900) == 0) row[j / 64] |= (uint64_t)1 << (j % 64);
        }
        cell_rows_set(&rows, i, row, &arena);
    }
    same_rows(&rows, dense, "set");
    CellRows copy = cell_rows_copy(&rows, &arena);
    for (int i = 0; i < ROW_CELLS; i++) {
        bool changed = false;
        for (int k = 0; k < ROW_WORDS; k++) {
            kept[k] = random_index(&random, 4) ? UINT64_MAX : random_next(&random);
            changed = changed || (dense[(size_t)i * ROW_WORDS + k] & ~kept[k]);
            dense[(size_t)i * ROW_WORDS + k] &= kept[k];
        }
        cr_assert_eq(cell_rows_keep(&rows, i, kept, &arena), changed);
    }
    same_rows(&rows, dense, "kept");
    cr_assert_not(cell_rows_equal(&rows, &copy));
    // First of the copy, whose stretches are full still.
    for (int turn = 0; turn < 2; turn++) {
        CellRows *one = turn ? &rows : &copy;
        uint64_t *both = ARENA_ARRAY(&arena, uint64_t, ROW_CELLS * ROW_WORDS);
        for (int i = 0; i < ROW_CELLS; i++)
            for (int j = 0; j < ROW_CELLS; j++)
                if (cell_rows_has(one, i, j) && cell_rows_has(one, j, i))
                    both[(size_t)i * ROW_WORDS + (size_t)j / 64] |= (uint64_t)1 << (j % 64);
        cell_rows_make_symmetric(one, &arena);
        same_rows(one, both, turn ? "both ways, with gaps" : "both ways");
    }
    memset(kept, 0, ROW_WORDS * sizeof *kept);
    cell_rows_join(&rows, 3, kept);
    cell_rows_join(&rows, ROW_CELLS - 1, kept);
    for (int j = 0; j < ROW_CELLS; j++)
        cr_assert_eq(kept[j / 64] >> (j % 64) & 1,
                     cell_rows_has(&rows, 3, j) || cell_rows_has(&rows, ROW_CELLS - 1, j));
    arena_free(&arena);
}

static void read_grid(Grown *g) {
    enum { CELLS = 95 * 95 };  // more than are searched pair by pair
    char path[] = "/tmp/enfilade-grid-XXXXXX.prt";
    int file = mkstemps(path, 4);
    cr_assert(file >= 0 && hostile_write(hostile_find("prt-grid"), CELLS, 1, path));
    close(file);
    Error error;
    VisOptions options = vis_default_options();
    *g = (Grown){.arena = {0}};
    cr_assert(maps_read(path, &g->arena, &g->building, &error), "%s", error.text);
    unlink(path);
    cr_assert(vis_build_cells(&g->building, &options, &g->arena, &g->graph, &error), "%s", error.text);
    cr_assert_gt(g->graph.cell_count, VIS_MANY_CELLS);
}

// Proves that trees of a building with too many cells for the search between pairs hold the ways of lines, that they are the same on any
// number of threads, that a cell whose tree is given up sees no less, and that all of this comes back from a file, unless its sets are
// broken.
Test(trees, of_very_many_cells, .timeout = 120) {
    Grown g;
    Random random = {3};
    Lines lines = {0};
    Error error = {""};
    StabForest back;
    read_grid(&g);
    trees_grow(&g, 1, false);
    StabForest first = g.forest;
    trees_grow(&g, 7, false);
    cr_assert_eq(g.forest.node_count, first.node_count);
    cr_assert_eq(memcmp(g.forest.nodes, first.nodes, sizeof *first.nodes * (size_t)first.node_count), 0);
    cr_assert(cell_rows_equal(&g.forest.seen, &first.seen));
    trees_expect_settled(&first);
    for (int c = 0; c < g.graph.cell_count; c += 61) trees_walk_lines("grid", &g, c, &random, &lines);
    cr_assert_gt(lines.far, 50, "%ld of %ld lines go far", lines.far, lines.walked);

    Arena arena = {0};
    const char *path = arena_format(&arena, "%s/grid.vis", support_folder(&arena));
    cr_assert(vis_save(path, &g.graph, &first, &error), "%s", error.text);
    cr_assert(vis_load(path, &g.graph, &arena, &back, &error), "%s", error.text);
    cr_assert(cell_rows_equal(&back.seen, &first.seen));
    cr_assert_eq(memcmp(back.nodes, first.nodes, sizeof *first.nodes * (size_t)first.node_count), 0);
    Bytes file = support_read(&arena, path);
    // A forged file, whose checksum is right.
    size_t header = sizeof(DerivedHead) + 4 * sizeof(int32_t),
           places = header + ((size_t)first.cell_count + 1) * sizeof(int32_t) + (size_t)first.cell_count;
    int32_t wrong = 1 << 20;
    memcpy(file.data + places, &wrong, sizeof wrong);
    uint64_t checksum = file_hash(file.data + header, file.size - header, 0);
    memcpy(file.data + offsetof(DerivedHead, body), &checksum, sizeof checksum);
    cr_assert(file_write(path, file.data, file.size, &error));
    cr_assert_not(vis_load(path, &g.graph, &arena, &back, &error));
    cr_assert(strstr(error.text, "its visible sets are broken"), "%s", error.text);
    arena_free(&arena);

    VisOptions options = vis_default_options();
    options.max_nodes = 1;
    cr_assert(vis_build_forest(&g.graph, &options, NULL, &g.arena, &g.forest));
    for (int c = 0; c < g.graph.cell_count; c++) {
        cr_assert(g.forest.bounded[c]);
        for (int i = first.root[c]; i < first.root[c + 1]; i++)
            cr_assert(vis_sees(&g.forest, c, first.nodes[i].cell), "cell %d without a tree sees less", c);
    }
    arena_free(&g.arena);
}
