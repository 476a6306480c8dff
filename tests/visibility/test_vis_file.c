// test_vis_file.c - .vis files are whole, or refused.
#include <criterion/criterion.h>
#include <limits.h>
#include <stdio.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "engine/core/polygon.h"
#include "tests/support/prt_scene.h"
#include "tests/support/support.h"
#include "tests/visibility/vis_fixture.h"

// Proves that a .vis file comes back as it went, and that damaged, cut and foreign files are refused.
Test(vis_file, refuses_what_is_not_whole) {
    Made m, other;
    vis_check_make(&m, 3, 2, 2, 1, 1, 0);
    vis_check_make(&other, 4, 2, 2, 1, 1, 0);
    char path[64];
    snprintf(path, sizeof path, "/tmp/enfilade-test-%d.vis", (int)getpid());
    Error error;
    StabForest back;
    Bytes good;
    cr_assert(vis_save(path, &m.graph, &m.forest, &error), "%s", error.text);
    cr_assert(vis_load(path, &m.graph, &m.arena, &back, &error), "%s", error.text);
    cr_assert_eq(back.node_count, m.forest.node_count);
    cr_assert_eq(memcmp(back.nodes, m.forest.nodes, (size_t)back.node_count * sizeof *back.nodes), 0);
    cr_assert_not(vis_load(path, &other.graph, &m.arena, &back, &error), "another building's file was taken");
    cr_assert(file_read(path, 1 << 30, &m.arena, &good, &error));
    Random random = {9};
    for (int i = 0; i < 300; i++) {
        Arena scratch = {0};
        unsigned char *bad = arena_alloc(&scratch, good.size, 1);
        memcpy(bad, good.data, good.size);
        size_t size = good.size;
        if (i % 2) {
            size = (size_t)(random_unit(&random) * (double)good.size);
        } else {
            bad[(size_t)(random_unit(&random) * (double)good.size)] ^=
                (unsigned char)(1 << random_index(&random, 8));
        }
        cr_assert(file_write(path, bad, size, &error));
        cr_assert_not(vis_load(path, &m.graph, &scratch, &back, &error), "case %d", i);
        arena_free(&scratch);
    }
    unlink(path);
    arena_free(&m.arena);
    arena_free(&other.arena);
}

// Proves that trees are taken for their own cells alone, of which any part may be another, and not when they lead astray: a file
// whose sum is right may be forged.
Test(vis_file, refuses_other_cells_and_forged_trees) {
    Arena arena = {0};
    Error error;
    StabForest back;
    char *path = arena_format(&arena, "%s/trees.vis", support_folder(&arena));
    Random random = {5};
    Row row = row_random(&random, 8);
    CellGraph *given = row_graph(&arena, &row);
    Made m;
    vis_check_make(&m, 3, 2, 2, 1, 1, 0);
    StabForest forest;
    VisOptions options = vis_default_options();
    cr_assert(vis_build_forest(given, &options, NULL, &arena, &forest));
    const CellGraph *graphs[2] = {given, &m.graph};
    const StabForest *forests[2] = {&forest, &m.forest};
    for (int k = 0; k < 2; k++) {
        const CellGraph *g = graphs[k];
        double *const PARTS[] = {g->face_count ? &g->faces[g->face_count - 1].d : &g->plan[0].x,
                                 &g->plan[g->plan_count - 1].y, &g->cells[g->cell_count - 1].z1,
                                 &g->portals[g->portal_count - 1].plane.d,
                                 &g->portal_vertices[g->portal_vertex_count - 1].z};
        cr_assert(vis_save(path, g, forests[k], &error), "%s", error.text);
        for (int i = 0; i < 5; i++) {
            double before = *PARTS[i];
            *PARTS[i] += 1;
            cr_expect_not(vis_load(path, g, &arena, &back, &error), "graph %d: part %d may be another", k, i);
            *PARTS[i] = before;
        }
        g->ways[g->way_count - 1].cell++;
        cr_expect_not(vis_load(path, g, &arena, &back, &error), "graph %d: ways may be others", k);
        g->ways[g->way_count - 1].cell--;
        cr_assert(vis_load(path, g, &arena, &back, &error), "%s", error.text);
        StabForest forged = *forests[k];
        int last = forged.root[1] - 1, nodes = forged.node_count;
        cr_assert_gt(last, 1);
        int *const FIELDS[] = {&forged.nodes[last].cell,
                               &forged.nodes[last].parent,
                               &forged.nodes[last].portal,
                               &forged.nodes[last].next,
                               &forged.nodes[0].parent,
                               &forged.nodes[0].cell,
                               &forged.root[0],
                               &forged.root[1],
                               &forged.root[forged.cell_count],
                               &forged.nodes[0].next};
        const int WRONG[][3] = {{-1, forged.cell_count, INT_MAX},
                                {-1, last, nodes},
                                {-1, g->portal_count, INT_MAX},
                                {last, nodes, 0},
                                {0, 1, -2},
                                {1, -1, forged.cell_count},
                                {1, -1, 2},
                                {0, nodes + 1, -1},
                                {nodes - 1, nodes + 1, 0},
                                {0, nodes, -2}};
        for (int i = 0; i < 10; i++) {
            for (int w = 0; w < 3; w++) {
                int before = *FIELDS[i];
                *FIELDS[i] = WRONG[i][w];
                cr_assert(vis_save(path, g, &forged, &error), "%s", error.text);
                *FIELDS[i] = before;
                cr_expect_not(vis_load(path, g, &arena, &back, &error), "graph %d: field %d is %d", k, i,
                              WRONG[i][w]);
            }
        }
    }
    arena_free(&m.arena);
    arena_free(&arena);
}
