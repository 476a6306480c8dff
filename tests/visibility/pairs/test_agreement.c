// test_agreement.c - the matrix of who sees whom, the stab trees and the query say the same of one building.
#include <criterion/criterion.h>

#include "maps/maps.h"
#include "tests/support/fixture.h"
#include "tests/support/prt_scene.h"
#include "tests/support/support.h"
#include "visibility/pairs/pairs.h"

typedef struct Known {
    Arena arena;
    Building building;
    CellGraph graph;
    PairSet set;
    StabForest forest;
} Known;

static void know(const char *path, Known *k) {
    Error error;
    VisOptions options = vis_default_options();
    *k = (Known){.arena = {0}};
    cr_assert(maps_read(path, &k->arena, &k->building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&k->building, &options, &k->arena, &k->graph, &error), "%s", error.text);
    pair_method_finest()->find(&k->graph, &(PairOptions){0}, NULL, &k->arena, &k->set);
    CellRows known = cell_rows_of_matrix(k->set.seen, k->set.cell_count, &k->arena);
    options.known = &known;
    cr_assert(vis_build_forest(&k->graph, &options, NULL, &k->arena, &k->forest));
}

// Proven pairs are in the trees' sets, and those leave out nothing but pairs that the matrix left undecided.
static void check_sets(const char *path, const Known *k) {
    const PairSet *set = &k->set;
    for (int i = 0; i < set->cell_count; i++) {
        for (int j = 0; j < set->cell_count; j++) {
            bool seen = pair_bit(set->seen, set->words, i, j),
                 proven = pair_bit(set->proven, set->words, i, j);
            bool kept = vis_sees(&k->forest, i, j);
            cr_assert(!proven || kept, "%s: cells %d and %d have a sightline, and the trees lack it", path, i,
                      j);
            cr_assert(!kept || seen, "%s: cells %d and %d cannot see each other, and the trees keep it", path,
                      i, j);
        }
    }
}

// A tree that was kept holds just the cells of its row.
static void check_trees(const char *path, const Known *k) {
    const StabForest *f = &k->forest;
    Arena scratch = {0};
    int *in_tree = ARENA_ARRAY(&scratch, int, f->cell_count);
    for (int c = 0; c < f->cell_count; c++) {
        if (f->bounded[c]) continue;
        for (int n = f->root[c]; n < f->root[c + 1]; n++) in_tree[f->nodes[n].cell] = c + 1;
        for (int d = 0; d < f->cell_count; d++) {
            cr_assert_eq(in_tree[d] == c + 1, vis_sees(f, c, d),
                         "%s: the tree of cell %d and its row differ in cell %d", path, c, d);
        }
    }
    arena_free(&scratch);
}

static void check_query(const char *path, const Known *k) {
    Arena scratch = {0};
    Random random = {7};
    VisQuery *query = vis_query_new(&k->graph, &k->forest, &scratch);
    for (int n = 0; n < 400; n++) {
        int cell = random_index(&random, k->graph.cell_count);
        // On a surface, so that near a wall the view begins in no other cell.
        Eye eye = {.position = fixture_point(&k->graph, &random, cell), .on_surface = true};
        VisResult result = vis_query(query, &eye, cell, NULL, CULL_STAB);
        for (int i = 0; i < result.cell_count; i++) {
            cr_assert(vis_sees(&k->forest, cell, result.cells[i].cell),
                      "%s: seed 7, eye %d: the query shows cell %d, which cell %d does not see", path, n,
                      result.cells[i].cell, cell);
        }
    }
    arena_free(&scratch);
}

static void check(const char *path, bool with_query) {
    Known k;
    know(path, &k);
    check_sets(path, &k);
    check_trees(path, &k);
    if (with_query) check_query(path, &k);
    arena_free(&k.arena);
}

Test(agreement, samples) {
    check("build/maps/two-rooms.plan", true);
    check("build/maps/house.plan", true);
    check("build/maps/office.plan", true);
}

Test(agreement, shared_maps) {
    Arena arena = {0};
    check(prt_file(&arena, "lqdm2_omitdetail", "build/maps/hillside.sh3d"), false);
    check(prt_file(&arena, "dm4", "build/maps/villa.sh3d"), false);
    check(support_either("doom/freedoom_dm07.wad", "build/maps/flat.Home.xml"), true);
    check(support_either("radiosity/twoRoom.quads", "tests/seeds/two-rooms.quads"), false);
    arena_free(&arena);
}
