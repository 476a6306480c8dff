// test_forest.c - stab trees hold every sightline, and the sequences that lines cross.
#include <criterion/criterion.h>
#include <stdio.h>
#include <unistd.h>

#include "engine/core/file.h"
#include "engine/core/polygon.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"
#include "tests/visibility/vis_fixture.h"

// Proves that stab trees are conservative: whatever way a straight line takes through portals is a path of the tree,
// and the visible sets hold its cells; the sets are symmetric; bounded trees keep the visible sets whole.
Test(forest, holds_every_sightline) {
    for (uint64_t seed = 1; seed <= 40; seed++) {
        Made m;
        bool bounded = seed % 4 == 0;
        vis_check_make(&m, seed, 4, 4, seed % 3 ? 1 : 2, 1, bounded ? 3 : 0);
        Random random = {seed * 77};
        for (int i = 0; i < 5000; i++) {
            int cell = random_index(&random, m.graph.cell_count);
            Trace trace;
            Vec3 direction = fixture_direction(&random);
            direction.z *= 0.2;  // mostly level: those lines go far
            if (!fixture_trace(&m.graph, cell, fixture_point(&m.graph, &random, cell), direction, NULL,
                               &trace))
                continue;
            for (int k = 0; k < trace.count; k++) {
                cr_assert(vis_sees(&m.forest, cell, trace.cells[k]), "seed %llu: cell %d sees %d",
                          (unsigned long long)seed, cell, trace.cells[k]);
            }
            if (!m.forest.bounded[cell])
                cr_assert(fixture_in_tree(&m.forest, &trace), "seed %llu", (unsigned long long)seed);
        }
        for (int a = 0; a < m.graph.cell_count; a++) {
            for (int b = 0; b < a; b++) cr_assert_eq(vis_sees(&m.forest, a, b), vis_sees(&m.forest, b, a));
        }
        arena_free(&m.arena);
    }
}

// ---- trees against all sequences there are

// A sequence of upright portals, as it is searched: what the plan shows of them, millimetres.
typedef struct Sequence {
    const CellGraph *graph;
    const StabForest *forest;
    Vec2 left[32], right[32];
    int cells[33];
    int count;
    long inside, outside;
} Sequence;

// The child of a node through a portal, or -1.
static int child_through(const StabForest *f, int node, int end, int portal) {
    int child = node + 1 < end && f->nodes[node + 1].parent == node ? node + 1 : -1;
    while (child >= 0 && f->nodes[child].portal != portal) child = f->nodes[child].next;
    return child;
}

// Goes on from a node through each portal: what a line crosses with room to spare is a child, what none crosses is not.
static void expect_children(Sequence *q, int node, uint64_t seed) {
    const CellGraph *g = q->graph;
    int root = q->cells[0], cell = q->cells[q->count], end = q->forest->root[root + 1];
    cr_assert_eq(q->forest->nodes[node].cell, cell);
    if (q->count == 31) return;
    for (int i = g->cells[cell].first_way; i < g->cells[cell].first_way + g->cells[cell].way_count; i++) {
        Way way = g->ways[i];
        const Portal *portal = &g->portals[way.portal];
        bool back = portal->cell[1] == cell, again = false;
        Vec2 ends[2] = {portal->left, portal->right};
        for (int k = 0; k < 2; k++) ends[k] = vec2(nearbyint(ends[k].x * 1000), nearbyint(ends[k].y * 1000));
        q->left[q->count] = ends[back];
        q->right[q->count] = ends[!back];
        for (int k = 0; k <= q->count; k++) again = again || q->cells[k] == way.cell;
        int child = child_through(q->forest, node, end, way.portal);
        bool crossed = !again && vis_check_crossed_inside(q->left, q->right, q->count + 1),
             touched = !again && vis_check_separable(q->left, q->right, q->count + 1);
        q->inside += crossed;
        q->outside += !touched;
        cr_assert(!crossed || child >= 0, "seed %llu: the tree of %d lacks a way of %d portals to %d",
                  (unsigned long long)seed, root, q->count + 1, way.cell);
        cr_assert(touched || child < 0,
                  "seed %llu: the tree of %d has a way of %d portals to %d that no line takes",
                  (unsigned long long)seed, root, q->count + 1, way.cell);
        if (child < 0) continue;
        q->cells[++q->count] = way.cell;
        expect_children(q, child, seed);
        q->count--;
    }
}

// Proves that trees hold the sequences of portals that some line crosses, all of them, and none that no line crosses: by trying all. On
// one storey, where all portals share a height, the plan decides. Each tree is in the order that it is stored in.
Test(forest, holds_the_sequences_that_lines_cross) {
    long inside = 0, outside = 0;
    for (uint64_t seed = 1; seed <= 12; seed++) {
        Made m;
        vis_check_make(&m, seed, 3, 2 + seed % 2, 1, 1, 0);
        if (seed % 3 == 0) vis_check_turn_away(&m, seed);
        VisOptions options = vis_default_options();
        cr_assert(vis_build_forest(&m.graph, &options, NULL, &m.arena, &m.forest));
        for (int c = 0; c < m.graph.cell_count; c++) {
            Sequence q = {.graph = &m.graph, .forest = &m.forest, .cells = {c}};
            int first = m.forest.root[c];
            cr_assert_eq(m.forest.nodes[first].parent, -1);
            cr_assert(!m.forest.bounded[c]);
            expect_children(&q, first, seed);
            for (int n = first + 1; n < m.forest.root[c + 1]; n++) {
                const StabNode *node = &m.forest.nodes[n];
                cr_assert(node->parent >= first && node->parent < n, "depth first");
                cr_assert(node->next < 0 ||
                          (node->next > n && m.forest.nodes[node->next].parent == node->parent));
            }
            inside += q.inside;
            outside += q.outside;
        }
        arena_free(&m.arena);
    }
    cr_assert(inside > 5000 && outside > 5000, "%ld sequences are crossed, %ld not", inside, outside);
}

// Four rooms a level, cut anew on each, so that most lie over several; some are missing.
static Building *tower(Arena *arena, Random *random) {
    Building *b = ARENA_ARRAY(arena, Building, 1);
    b->source = "tower";
    building_add_material(arena, b,
                          (Material){.name = "stone", .reflectance = {0.5f, 0.5f, 0.5f}, .alpha = 1});
    for (int level = 0; level < 4; level++) {
        double x[3] = {0, maps_snap(random_between(random, 1, 5)), 6},
               y[3] = {0, maps_snap(random_between(random, 1, 5)), 6};
        for (int k = 0; k < 4; k++) {
            double x0 = x[k % 2], x1 = x[k % 2 + 1], y0 = y[k / 2], y1 = y[k / 2 + 1];
            const Vec2 p[4] = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
            if (random_index(random, 4)) vis_check_add_region(arena, b, p, 4, 3 * level, 3 * level + 3);
        }
    }
    b->world = (Box){{0, 0, 0}, {6, 6, 12}};
    return b;
}

// Proves that no sequence goes up through a floor and down through another, in towers of rooms that overlap anyhow: a straight line
// does not.
Test(forest, does_not_turn_back_in_height) {
    long levels = 0;
    for (uint64_t seed = 1; seed <= 10; seed++) {
        Random random = {seed};
        Arena arena = {0};
        CellGraph g;
        StabForest f;
        Error error;
        VisOptions options = vis_default_options();
        Building *b = tower(&arena, &random);
        cr_assert(vis_build_cells(b, &options, &arena, &g, &error), "%s", error.text);
        cr_assert(vis_build_forest(&g, &options, NULL, &arena, &f));
        for (int c = 0; c < g.cell_count; c++) {
            for (int n = f.root[c]; n < f.root[c + 1]; n++) {
                int up = 0, down = 0;
                for (int k = n; f.nodes[k].parent >= 0; k = f.nodes[k].parent) {
                    const Portal *portal = &g.portals[f.nodes[k].portal];
                    if (!portal->horizontal) continue;
                    double rise = g.cells[f.nodes[k].cell].z0 - g.cells[f.nodes[f.nodes[k].parent].cell].z0;
                    up += rise > 0, down += rise < 0;
                }
                levels += up + down > 1;
                cr_assert(up == 0 || down == 0, "seed %llu: a way from %d to %d goes up and down",
                          (unsigned long long)seed, c, f.nodes[n].cell);
            }
        }
        arena_free(&arena);
    }
    cr_assert_gt(levels, 1000);
}

// Proves determinism: the same .vis bytes on 1, 2 and 7 threads.
Test(forest, is_the_same_on_any_number_of_threads) {
    char path[3][64];
    Bytes bytes[3];
    Arena arena = {0};
    const int threads[3] = {1, 2, 7};
    for (int i = 0; i < 3; i++) {
        Made m;
        vis_check_make(&m, 11, 5, 5, 2, threads[i], 0);
        snprintf(path[i], sizeof path[i], "/tmp/enfilade-test-%d-%d.vis", (int)getpid(), i);
        Error error;
        cr_assert(vis_save(path[i], &m.graph, &m.forest, &error), "%s", error.text);
        cr_assert(file_read(path[i], 1 << 30, &arena, &bytes[i], &error), "%s", error.text);
        unlink(path[i]);
        arena_free(&m.arena);
        cr_assert_eq(bytes[i].size, bytes[0].size);
        cr_assert_eq(memcmp(bytes[i].data, bytes[0].data, bytes[0].size), 0);
    }
    arena_free(&arena);
}
