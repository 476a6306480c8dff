// test_campus.c - pairs and trees of large buildings, group by group.
#include <criterion/criterion.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/core/memory.h"
#include "maps/maps.h"
#include "tests/support/support.h"
#include "visibility/pairs/campus.h"
#include "visibility/window.h"

typedef struct Made {
    Arena arena;
    Building building;
    CellGraph graph;
} Made;

// Rooms in rows, each with a doorway to the right and one upwards, anywhere along their walls; none to the right of the columns `ends`,
// up to the first -1.
static void make_rooms(int side, const int *ends, Made *m) {
    Error error;
    VisOptions options = vis_default_options();
    *m = (Made){.arena = {0}};
    const char *path = arena_format(&m->arena, "%s/rows.plan", support_folder(&m->arena));
    FILE *file = fopen(path, "w");
    cr_assert(file);
    fputs("plan 1\nmaterial m #808080\nstorey s floor 0 height 2.7\n", file);
    for (int k = 0; k < side * side; k++) {
        // Scattered alike in buildings of any side.
        int column = k % side, row = k / side;
        double x = 4.1 * column, y = 4.1 * row,
               aside = 0.05 * ((column * 7919 + row * 6841 + column * row * 2657) % 41) - 1;
        fprintf(file, "room r%d %.2f,%.2f %.2f,%.2f %.2f,%.2f %.2f,%.2f wall 0.1\n", k, x, y, x + 4, y, x + 4,
                y + 4, x, y + 4);
        bool end = (k + 1) % side == 0;
        for (int i = 0; ends[i] >= 0; i++) end = end || column == ends[i];
        if (!end)
            fprintf(file, "passage x%d %.2f,%.2f angle 90 width 0.9 height 2.1\n", k, x + 4.05,
                    y + 2 + aside);
        if (k / side + 1 < side)
            fprintf(file, "passage y%d %.2f,%.2f width 0.9 height 2.1\n", k, x + 2 - aside, y + 4.05);
    }
    cr_assert_eq(fclose(file), 0);
    cr_assert(maps_read(path, &m->arena, &m->building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&m->building, &options, &m->arena, &m->graph, &error), "%s", error.text);
}

static const int ONE_HOUSE[] = {-1};

// Proves that houses without a way between them, some of a few cells and some large enough for windows, have the pairs that one matrix
// of all of them has, and that a house takes the work that it takes alone.
Test(campus, houses_are_buildings_of_their_own, .timeout = 120) {
    Made m;
    CampusPairs found, alone;
    PairSet set;
    make_rooms(46, (const int[]){0, 1, 2, 19, -1}, &m);
    CellGroups houses = cell_houses(&m.graph, WINDOW_GROUP, &m.arena);
    cr_assert_geq(houses.count, 2);
    bool small = false, large = false;
    for (int h = 0; h < houses.count; h++) {
        int cells = houses.first[h + 1] - houses.first[h];
        small = small || cells <= WINDOW_LEAST;
        large = large || cells > WINDOW_LEAST;
    }
    cr_assert(small && large);
    cr_assert(campus_pairs(&m.graph, &(PairOptions){.threads = 2}, NULL, &m.arena, &found));
    pair_method_finest()->find(&m.graph, &(PairOptions){.threads = 2}, NULL, &m.arena, &set);
    CellRows whole = cell_rows_of_matrix(set.seen, set.cell_count, &m.arena);
    cr_expect(cell_rows_equal(&found.seen, &whole));
    cr_expect_eq(found.undecided, 0);
    arena_free(&m.arena);

    // Six houses, each of eight columns and more than WINDOW_GROUP cells: together they take the work that they take one by one.
    make_rooms(48, (const int[]){7, 15, 23, 31, 39, -1}, &m);
    cr_assert(campus_pairs(&m.graph, &(PairOptions){.threads = 1}, NULL, &m.arena, &found));
    int *place = ARENA_ARRAY(&m.arena, int, m.graph.cell_count);
    for (int c = 0; c < m.graph.cell_count; c++) place[c] = -1;
    houses = cell_houses(&m.graph, WINDOW_GROUP, &m.arena);
    cr_assert_eq(houses.count, 6);
    long long chains = 0;
    for (int h = 0; h < houses.count; h++) {
        CellWindow house;
        int first = houses.first[h];
        window_of_house(&m.graph, houses.cell + first, houses.first[h + 1] - first, place, &m.arena, &house);
        cr_assert(campus_pairs(&house.graph, &(PairOptions){.threads = 1}, NULL, &m.arena, &alone));
        chains += alone.work.chains;
        window_leave(&house, place);
    }
    cr_expect_eq(found.work.chains, chains);
    arena_free(&m.arena);
}

// Proves that pairs found in windows are those of one matrix, on any number of threads, and that trees grown in windows lose
// nothing: each of their cells is in the sets of both.
Test(campus, windows_find_what_a_matrix_finds, .timeout = 120) {
    Made m;
    CampusPairs one, three;
    PairSet set;
    make_rooms(25, ONE_HOUSE, &m);
    cr_assert_gt(m.graph.cell_count, WINDOW_LEAST);
    cr_assert(campus_pairs(&m.graph, &(PairOptions){.threads = 1}, NULL, &m.arena, &one));
    cr_assert(campus_pairs(&m.graph, &(PairOptions){.threads = 3}, NULL, &m.arena, &three));
    cr_assert(window_pays(&one.seen), "the building is searched in one matrix");
    pair_method_finest()->find(&m.graph, &(PairOptions){.threads = 1}, NULL, &m.arena, &set);
    CellRows whole = cell_rows_of_matrix(set.seen, set.cell_count, &m.arena);
    cr_expect(cell_rows_equal(&one.seen, &three.seen));
    cr_expect(cell_rows_equal(&one.seen, &whole));
    cr_expect_eq(one.undecided, 0);
    cr_expect_eq(one.work.chains, three.work.chains);

    // Without known pairs trees are grown in the whole building, and hold all lines.
    VisOptions options = vis_default_options();
    StabForest near, all;
    options.known = &one.seen;
    cr_assert(vis_build_forest(&m.graph, &options, NULL, &m.arena, &near));
    options.known = NULL;
    cr_assert(vis_build_forest(&m.graph, &options, NULL, &m.arena, &all));
    for (int c = 0; c < m.graph.cell_count; c++)
        for (int i = near.root[c]; i < near.root[c + 1]; i++) {
            cr_assert(vis_sees(&all, c, near.nodes[i].cell));
            cr_assert(cell_rows_has(&one.seen, c, near.nodes[i].cell));
        }
    arena_free(&m.arena);
}

typedef struct Memory {
    size_t before, most;  // bytes in use at first; at most above them
} Memory;

static bool watch_memory(void *context, const char *stage, double done) {
    Memory *memory = context;
    size_t used = memory_used() - memory->before;
    (void)stage, (void)done;
    if (used > memory->most) memory->most = used;
    return true;
}

// Proves that work and memory for a visible pair do not grow with the number of rooms. Tolerance: beams are not alike everywhere; a search
// over all pairs would take six times as much for a pair of the larger building.
Test(campus, cost_of_a_room_stays, .timeout = 120) {
    double chains[2], bytes[2], pairs[2], search[2];
    for (int k = 0; k < 2; k++) {
        Made m;
        CampusPairs found;
        Arena arena = {0};
        int side = k ? 64 : 25;
        make_rooms(side, ONE_HOUSE, &m);
        Memory memory = {.before = memory_used()};
        Progress progress = {watch_memory, &memory};
        cr_assert(campus_pairs(&m.graph, &(PairOptions){.threads = 1}, &progress, &arena, &found));
        chains[k] = (double)found.work.chains / (side * side);
        bytes[k] = (double)arena.used / (side * side);
        pairs[k] = (double)cell_rows_count(&found.seen) / (side * side);
        search[k] = (double)memory.most / (side * side);
        arena_free(&arena);
        arena_free(&m.arena);
    }
    cr_expect_lt(search[1] / pairs[1], 1.15 * search[0] / pairs[0], "%g and %g bytes a pair in use",
                 search[1] / pairs[1], search[0] / pairs[0]);
    cr_expect_lt(chains[1] / pairs[1], 1.15 * chains[0] / pairs[0], "%g and %g chains a pair",
                 chains[1] / pairs[1], chains[0] / pairs[0]);
    // A word for each pair, and as much again for gaps and heads of runs: a matrix would take 30 bytes for a pair of the larger one.
    for (int k = 0; k < 2; k++)
        cr_expect_lt(bytes[k], 16 * pairs[k], "%g bytes, %g pairs", bytes[k], pairs[k]);
}
