// test_views.c - queries lose nothing, and finer ways of culling draw less.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"
#include "tests/visibility/vis_fixture.h"
#include "visibility/query/query.h"

static Eye random_eye(const Made *m, Random *random, int *cell) {
    *cell = random_index(random, m->graph.cell_count);
    Eye eye = {.position = fixture_point(&m->graph, random, *cell)};
    if (random_unit(random) < 0.2) return eye;  // all directions
    Vec3 forward = fixture_direction(random), side = fixture_direction(random);
    Vec3 right = vec3_normalize(vec3_cross(forward, side)), up = vec3_cross(right, forward);
    double x = random_between(random, 0.2, 1.5), y = random_between(random, 0.2, 1.5);
    Vec3 n[4] = {vec3_add(right, vec3_scale(forward, x)), vec3_sub(vec3_scale(forward, x), right),
                 vec3_add(up, vec3_scale(forward, y)), vec3_sub(vec3_scale(forward, y), up)};
    eye.frustum_count = 4;
    for (int i = 0; i < 4; i++) {
        n[i] = vec3_normalize(n[i]);
        eye.frustum[i] = (Plane){n[i], vec3_dot(n[i], eye.position)};
    }
    return eye;
}

// An eye exactly on a portal, or on the plane of its cell's portal, or in a corner of it.
static void put_on_portal(const Made *m, Random *random, int cell, Eye *eye) {
    const Cell *c = &m->graph.cells[cell];
    if (c->way_count == 0) return;
    const Way *way = &m->graph.ways[c->first_way + random_index(random, c->way_count)];
    const Portal *portal = &m->graph.portals[way->portal];
    const Vec3 *v = m->graph.portal_vertices + portal->first_vertex;
    double s = random_unit(random), t = random_unit(random);
    if (random_unit(random) < 0.2) s = 0;
    Vec3 p = vec3_add(v[0], vec3_add(vec3_scale(vec3_sub(v[1], v[0]), s),
                                     vec3_scale(vec3_sub(v[portal->vertex_count - 1], v[0]), t)));
    Vec3 moved = vec3_sub(p, eye->position);
    eye->position = p;
    for (int i = 0; i < eye->frustum_count; i++) eye->frustum[i].d += vec3_dot(eye->frustum[i].n, moved);
}

static bool in_view(const Eye *eye, Vec3 direction) {
    for (int i = 0; i < eye->frustum_count; i++) {
        if (vec3_dot(eye->frustum[i].n, direction) < 1e-9) return false;
    }
    return true;
}

static bool drawn_surface_at(const CellGraph *g, const VisResult *result, int cell, Vec3 hit) {
    for (int i = 0; i < result->object_count; i++) {
        int object = result->objects[i];
        bool surface = object >= g->surface_first[cell] && object < g->surface_first[cell + 1];
        bool leaf = g->objects[object].kind == OBJECT_LEAF;
        if ((surface || leaf) && box_contains(box_grow(g->object_boxes[object], 1e-6), hit)) return true;
    }
    return false;
}

// Proves that a query loses nothing: a line from the eye inside the view, through open portals, ends on a surface
// that is drawn, in a cell that is listed; with random doors, views, and eyes on portals, by every culling.
Test(query, loses_nothing) {
    for (uint64_t seed = 1; seed <= 24; seed++) {
        Made m;
        vis_check_make(&m, seed, 4, 4, seed % 3 ? 1 : 2, 1, seed % 4 == 0 ? 3 : 0);
        VisQuery *query = vis_query_new(&m.graph, &m.forest, &m.arena);
        Random random = {seed * 31};
        float *doors = ARENA_ARRAY(&m.arena, float, m.building->opening_count);
        for (int i = 0; i < 300; i++) {
            int cell;
            Eye eye = random_eye(&m, &random, &cell);
            if (i % 4 == 0) put_on_portal(&m, &random, cell, &eye);
            for (int d = 0; d < m.building->opening_count; d++) doors[d] = random_unit(&random) < 0.6;
            Culling culling = (Culling)(CULL_PORTALS + i % 3);
            VisResult result = vis_query(query, &eye, cell, doors, culling);
            for (int k = 0; k < 200; k++) {
                Vec3 direction = fixture_direction(&random);
                direction.z *= 0.3;
                Trace trace;
                if (!in_view(&eye, direction)) continue;
                if (!fixture_trace(&m.graph, cell, eye.position, direction, doors, &trace)) continue;
                cr_assert(drawn_surface_at(&m.graph, &result, trace.cells[trace.count - 1], trace.hit),
                          "seed %llu, eye %d, line %d, culling %s: the surface at (%g, %g, %g) is not drawn",
                          (unsigned long long)seed, i, k, CULLING_NAMES[culling], trace.hit.x, trace.hit.y,
                          trace.hit.z);
            }
        }
        arena_free(&m.arena);
    }
}

// Proves that culling culls, and that each culling draws no more than the weaker one: trees no more than run-time
// portals, three dimensions no more than two, and all no more than everything.
Test(query, methods_are_ordered) {
    Made m;
    vis_check_make(&m, 2, 6, 6, 1, 1, 0);
    VisQuery *query = vis_query_new(&m.graph, &m.forest, &m.arena);
    Random random = {5};
    double drawn[QUERY_CULLINGS] = {0};
    for (int i = 0; i < 300; i++) {
        int cell, count[QUERY_CULLINGS];
        Eye eye = random_eye(&m, &random, &cell);
        for (int k = 0; k < QUERY_CULLINGS; k++) {
            count[k] = vis_query(query, &eye, cell, NULL, (Culling)k).polygon_count;
            drawn[k] += count[k];
        }
        cr_assert(count[CULL_STAB] <= count[CULL_PORTALS] && count[CULL_FRUSTUM] <= count[CULL_NONE]);
    }
    cr_assert_lt(drawn[CULL_STAB], drawn[CULL_PLAN]);
    cr_assert_lt(drawn[CULL_STAB], 0.25 * drawn[CULL_NONE]);
    arena_free(&m.arena);
}

static void expect_same(const VisResult *a, const VisResult *b, int eye) {
    cr_assert(a->cell_count == b->cell_count && a->object_count == b->object_count &&
                  a->polygon_count == b->polygon_count && a->portals_tested == b->portals_tested,
              "eye %d: %d and %d cells, %d and %d objects", eye, a->cell_count, b->cell_count,
              a->object_count, b->object_count);
    for (int i = 0; i < a->cell_count; i++)
        cr_assert(a->cells[i].cell == b->cells[i].cell && a->cells[i].distance == b->cells[i].distance);
    for (int i = 0; i < a->object_count; i++) cr_assert_eq(a->objects[i], b->objects[i]);
}

// Proves that queries with shared lists tell what one with lists of its own does, to the last bit, though two of them are asked in turn for
// other eyes; and that it does so still after the lists are shared. Storeys have level portals, whose parts in view queries keep.
Test(query, shared_lists_change_nothing) {
    enum { QUERIES = 3, EYES = 600 };
    Made m;
    vis_check_make(&m, 4, 4, 4, 2, 1, 0);
    VisQuery *own = vis_query_new(&m.graph, &m.forest, &m.arena), *query[QUERIES];
    vis_share_query(&m.graph, &m.forest, &m.arena);
    for (int i = 0; i < QUERIES; i++) query[i] = vis_query_new(&m.graph, &m.forest, &m.arena);
    cr_assert(query[0]->ways == query[1]->ways && query[0]->ways != own->ways);
    cr_expect_gt(own->sloped_count, 0);
    Random random = {9};
    float *doors = ARENA_ARRAY(&m.arena, float, m.building->opening_count + 1);
    for (int i = 0; i < EYES; i++) {
        int cell;
        Eye eye = random_eye(&m, &random, &cell);
        Culling culling = (Culling)(CULL_PORTALS + i % 3);
        for (int d = 0; d < m.building->opening_count; d++) doors[d] = random_unit(&random) < 0.6;
        VisResult expected = vis_query(own, &eye, cell, doors, culling),
                  shared = vis_query(query[i % QUERIES], &eye, cell, doors, culling);
        expect_same(&expected, &shared, i);
    }
    arena_free(&m.arena);
}

// Proves that opening a door hides nothing.
Test(query, opening_a_door_hides_nothing) {
    Made m;
    vis_check_make(&m, 8, 4, 4, 1, 1, 0);
    VisQuery *query = vis_query_new(&m.graph, &m.forest, &m.arena);
    Random random = {6};
    float *doors = ARENA_ARRAY(&m.arena, float, m.building->opening_count + 1);
    unsigned char *before = ARENA_ARRAY(&m.arena, unsigned char, m.graph.cell_count);
    for (int i = 0; i < 300; i++) {
        int cell;
        Eye eye = random_eye(&m, &random, &cell);
        for (int d = 0; d < m.building->opening_count; d++) doors[d] = random_unit(&random) < 0.5;
        VisResult result = vis_query(query, &eye, cell, doors, CULL_STAB);
        memset(before, 0, (size_t)m.graph.cell_count);
        for (int k = 0; k < result.cell_count; k++) before[result.cells[k].cell] = 1;
        if (m.building->opening_count) doors[random_index(&random, m.building->opening_count)] = 1;
        result = vis_query(query, &eye, cell, doors, CULL_STAB);
        for (int k = 0; k < result.cell_count; k++) before[result.cells[k].cell] = 0;
        for (int c = 0; c < m.graph.cell_count; c++) cr_assert_eq(before[c], 0, "eye %d, cell %d", i, c);
    }
    arena_free(&m.arena);
}
