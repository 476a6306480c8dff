// soup_checks.c - see the header.
#include "tests/visibility/soup/soup_checks.h"

#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "tests/support/soup_fixture.h"
#include "tests/support/support.h"
#include "visibility/pairs/pairs.h"
#include "visibility/soup/soup.h"

CellGraph soup_make(Arena *arena, const Building *b) {
    VisOptions options = vis_default_options();
    CellGraph graph;
    Error error = {""};
    cr_assert(vis_build_cells(b, &options, arena, &graph, &error), "%s", error.text);
    return graph;
}

int soup_reachable(const CellGraph *g, int start, unsigned char *reached) {
    int count = 1;
    memset(reached, 0, (size_t)g->cell_count);
    reached[start] = 1;
    for (bool more = true; more;) {
        more = false;
        for (int p = 0; p < g->portal_count; p++) {
            const int *cell = g->portals[p].cell;
            if (reached[cell[0]] == reached[cell[1]]) continue;
            reached[cell[0]] = reached[cell[1]] = 1;
            count++;
            more = true;
        }
    }
    return count;
}

bool soup_connected(const CellGraph *g, Vec3 a, Vec3 b) {
    unsigned char reached[4096];
    int from = vis_locate(g, a, -1), to = vis_locate(g, b, -1);
    cr_assert(from >= 0 && to >= 0 && g->cell_count <= 4096);
    soup_reachable(g, from, reached);
    return reached[to];
}

void soup_extent_of(const SoupCell *cell, Plane plane, double *low, double *high) {
    *low = INFINITY, *high = -INFINITY;
    for (int i = 0; i < cell->face_count; i++) {
        for (int k = 0; k < cell->faces[i].count; k++) {
            *low = fmin(*low, plane_distance(plane, cell->faces[i].v[k]));
            *high = fmax(*high, plane_distance(plane, cell->faces[i].v[k]));
        }
    }
}

void soup_expect_polyhedron(const Soup *soup, const SoupCell *cell) {
    Vec3 open = {0, 0, 0};
    for (int i = 0; i < cell->face_count; i++) {
        const CellFace *f = &cell->faces[i];
        Plane inward = soup_inward(soup, f);
        double low, high;
        soup_extent_of(cell, inward, &low, &high);
        cr_assert(low > -1e-8 && high > 0, "a corner is %g m outside face %d", -low, i);
        cr_assert_lt(polygon_bend(f->v, f->count, inward), 1e-8);
        Vec3 area = vec3_scale(plane_of_polygon(f->v, f->count).n, polygon_area(f->v, f->count));
        cr_assert_gt(vec3_dot(area, inward.n), 0);
        open = vec3_add(open, area);
        for (int k = 0; k < i; k++) cr_assert(cell->faces[k].plane != f->plane, "one face a plane");
    }
    cr_assert_lt(vec3_length(open), 1e-7);
}

Building *soup_closed_room(Arena *arena, Vec3 size) {
    Building *b = soup_fixture_new(arena);
    soup_fixture_box(arena, b, vec3(0, 0, 0), size, 0);
    return b;
}
