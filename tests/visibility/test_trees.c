// test_trees.c - stab trees in three dimensions: they hold every sequence of portals that a line crosses, and where heights
// part what the plan shows together, they leave it out.
#include <criterion/criterion.h>
#include <stdlib.h>
#include <unistd.h>

#include "engine/core/memory.h"
#include "maps/maps.h"
#include "tests/support/fixture.h"
#include "tests/support/hostile.h"
#include "tests/support/prt_scene.h"
#include "tests/support/support.h"
#include "visibility/pairs/pairs.h"

typedef struct Grown {
    Arena arena;
    Building building;
    CellGraph graph;
    PairSet set;
    StabForest forest;
} Grown;

static void read_cells(const char *path, Grown *g) {
    Error error;
    VisOptions options = vis_default_options();
    *g = (Grown){.arena = {0}};
    cr_assert(maps_read(path, &g->arena, &g->building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&g->building, &options, &g->arena, &g->graph, &error), "%s", error.text);
    pair_method_finest()->find(&g->graph, &(PairOptions){0}, NULL, &g->arena, &g->set);
}

static void grow(Grown *g, int threads, bool known) {
    VisOptions options = vis_default_options();
    options.threads = threads;
    options.known = known ? g->set.seen : NULL;
    cr_assert(vis_build_forest(&g->graph, &options, NULL, &g->arena, &g->forest));
}

static Vec3 on_portal(const CellGraph *graph, int portal, Random *random) {
    const Portal *p = &graph->portals[portal];
    Vec3 sum = {0, 0, 0};
    double total = 0;
    for (int i = 0; i < p->vertex_count; i++) {
        double weight = 1e-3 + random_unit(random);
        sum = vec3_add(sum, vec3_scale(graph->portal_vertices[p->first_vertex + i], weight));
        total += weight;
    }
    return vec3_scale(sum, 1 / total);
}

// A place in the cell, between two of its portals.
static Vec3 in_cell(const CellGraph *graph, int c, Random *random) {
    const Cell *cell = &graph->cells[c];
    const Way *ways = graph->ways + cell->first_way;
    Vec3 a = on_portal(graph, ways[random_index(random, cell->way_count)].portal, random);
    Vec3 b = on_portal(graph, ways[random_index(random, cell->way_count)].portal, random);
    return vec3_lerp(a, b, random_between(random, 0.2, 0.8));
}

// Sight is symmetric, and trees hold the cells that their roots see, each way through cells that they see.
static void expect_settled(const StabForest *f) {
    unsigned char *met = memory_grow(NULL, (size_t)f->cell_count);
    for (int a = 0; a < f->cell_count; a++) {
        memset(met, 0, (size_t)f->cell_count);
        for (int n = f->root[a]; n < f->root[a + 1]; n++) {
            cr_assert(vis_sees(f, a, f->nodes[n].cell), "the tree of %d holds %d, which it does not see", a,
                      f->nodes[n].cell);
            met[f->nodes[n].cell] = 1;
        }
        for (int b = 0; b < f->cell_count; b++) {
            cr_assert_eq(vis_sees(f, a, b), vis_sees(f, b, a), "of %d and %d one sees the other", a, b);
            cr_assert(f->bounded[a] || vis_sees(f, a, b) == met[b], "%d sees %d by no way of its tree", a, b);
        }
    }
    memory_free(met);
}

typedef struct Lines {
    long walked, far;  // of these through five portals or more
} Lines;

// Lines from a cell towards portals that it sees, so that they go far; each way that one takes is a path of the tree.
static void walk_lines(const char *path, const Grown *g, int cell, Random *random, Lines *lines) {
    const StabForest *f = &g->forest;
    if (f->bounded[cell] || f->root[cell + 1] - f->root[cell] < 2) return;
    for (int i = 0; i < 40; i++) {
        int node = f->root[cell] + 1 + random_index(random, f->root[cell + 1] - f->root[cell] - 1);
        Vec3 from = in_cell(&g->graph, cell, random);
        Vec3 along = vec3_sub(on_portal(&g->graph, f->nodes[node].portal, random), from);
        Trace trace;
        if (vec3_length(along) < 1e-3) continue;
        if (!fixture_trace(&g->graph, cell, from, vec3_normalize(along), NULL, &trace)) continue;
        cr_assert(fixture_in_tree(f, &trace),
                  "%s: a line from cell %d to cell %d takes a way that its tree lacks", path, cell,
                  trace.cells[trace.count - 1]);
        lines->walked++;
        lines->far += trace.count > 5;
    }
}

static void check_lines(const char *path, bool known) {
    Grown g;
    Lines lines = {0};
    Random random = {9};
    read_cells(path, &g);
    grow(&g, 0, known);
    expect_settled(&g.forest);
    for (int i = 0; i < support_count(1000, 50000); i++) {
        int cell = random_index(&random, g.graph.cell_count);
        if (g.graph.cells[cell].way_count > 0) walk_lines(path, &g, cell, &random, &lines);
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
        expect_settled(&forest);
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
        grow(&g, THREADS[i], true);
        if (i == 0) first = g.forest;
        cr_assert_eq(g.forest.node_count, first.node_count);
        cr_expect_eq(memcmp(g.forest.nodes, first.nodes, sizeof *first.nodes * (size_t)first.node_count), 0);
        cr_expect_eq(memcmp(g.forest.bounded, first.bounded, (size_t)first.cell_count), 0);
        cr_expect(cell_rows_equal(&g.forest.seen, &first.seen));
    }
    arena_free(&arena);
    arena_free(&g.arena);
}

// ---- large buildings

enum { ROW_CELLS = 3 * CELL_BLOCK - 100, ROW_WORDS = (ROW_CELLS + 63) / 64 };

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

// Proves that sparse sets are the sets of a matrix of bits through all that is done with them. Rows of the first block hold all
// cells but a few, so that full blocks face full ones and ones with gaps; others hold few cells or none.
Test(cell_rows, hold_what_a_matrix_holds) {
    Arena arena = {0};
    Random random = {11};
    CellRows rows = cell_rows_new(ROW_CELLS, &arena);
    uint64_t *dense = ARENA_ARRAY(&arena, uint64_t, ROW_CELLS * ROW_WORDS),
             *kept = ARENA_ARRAY(&arena, uint64_t, ROW_WORDS);
    for (int i = 0; i < ROW_CELLS; i++) {
        uint64_t *row = dense + (size_t)i * ROW_WORDS;
        bool full = i < CELL_BLOCK || i % 7 == 0;
        for (int j = 0; j < ROW_CELLS; j++) {
            bool gap = j % CELL_BLOCK == 5 && i % 90 == 3;
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
    // Grows trees of the copy, whose blocks are full still.
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
    grow(&g, 1, false);
    StabForest first = g.forest;
    grow(&g, 7, false);
    cr_assert_eq(g.forest.node_count, first.node_count);
    cr_assert_eq(memcmp(g.forest.nodes, first.nodes, sizeof *first.nodes * (size_t)first.node_count), 0);
    cr_assert(cell_rows_equal(&g.forest.seen, &first.seen));
    expect_settled(&first);
    for (int c = 0; c < g.graph.cell_count; c += 61) walk_lines("grid", &g, c, &random, &lines);
    cr_assert_gt(lines.far, 50, "%ld of %ld lines go far", lines.far, lines.walked);

    Arena arena = {0};
    const char *path = arena_format(&arena, "%s/grid.vis", support_folder(&arena));
    cr_assert(vis_save(path, &g.graph, &first, &error), "%s", error.text);
    cr_assert(vis_load(path, &g.graph, &arena, &back, &error), "%s", error.text);
    cr_assert(cell_rows_equal(&back.seen, &first.seen));
    cr_assert_eq(memcmp(back.nodes, first.nodes, sizeof *first.nodes * (size_t)first.node_count), 0);
    Bytes file = support_read(&arena, path);
    size_t places = 40 + 4 * sizeof(int32_t) + ((size_t)first.cell_count + 1) * sizeof(int32_t) +
                    (size_t)first.cell_count;
    int32_t wrong = 1 << 20;
    memcpy(file.data + places, &wrong, sizeof wrong);
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
