// trees_fixture.c - see the header.
#include "tests/visibility/trees_fixture.h"

#include <criterion/criterion.h>

#include "engine/core/memory.h"
#include "tests/support/files/hostile.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"
#include "visibility/pairs/pairs.h"

void trees_grow(Grown *g, int threads, bool known) {
    VisOptions options = vis_default_options();
    options.threads = threads;
    CellRows rows;
    if (known) {
        rows = cell_rows_of_matrix(g->set.seen, g->set.cell_count, &g->arena);
        options.known = &rows;
    }
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

void trees_expect_settled(const StabForest *f) {
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

void trees_walk_lines(const char *path, const Grown *g, int cell, Random *random, Lines *lines) {
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
