// test_soup_scenes.c - soups of buildings, shapes and polygons at random.
#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "tests/support/fixture.h"
#include "tests/support/soup_fixture.h"
#include "tests/support/support.h"
#include "tests/visibility/soup/soup_checks.h"
#include "tests/visibility/soup/soup_scenes.h"
#include "visibility/pairs/pairs.h"

// The shadow and the extent of each cell hold points of it, and touch its corners: no line along a side of them misses all
// portals and faces.
static void check_extents(const CellGraph *g, Random *random) {
    double near = 1e-6 * soup_largest_extent(g);
    for (int c = 0; c < g->cell_count; c++) {
        const Cell *cell = &g->cells[c];
        const Vec2 *plan = g->plan + cell->first_edge;
        Box box = box_empty();
        cr_assert(cell->z0 == cell->box.min.z && cell->z1 == cell->box.max.z && cell->z0 < cell->z1);
        for (int i = 0; i < cell->edge_count; i++) {
            Vec2 a = plan[i], b = plan[(i + 1) % cell->edge_count];
            box = box_add(box_add(box, vec3(a.x, a.y, cell->z0)), vec3(a.x, a.y, cell->z1));
            // Both ends are known to `near`, and so the line through them, less and less beyond.
            for (int k = 0; k < 20; k++) {
                Vec3 p = soup_fixture_point(g, random, c);
                Vec2 along = vec2_sub(b, a), to = vec2_sub(vec2(p.x, p.y), a);
                cr_assert_geq(vec2_cross(along, to), -near * (vec2_length(along) + vec2_length(to)));
                cr_assert(box_contains(box_grow(cell->box, near), p));
            }
        }
        cr_assert(box_contains(box_grow(box, near), cell->box.min) &&
                  box_contains(box_grow(box, near), cell->box.max));
        cr_assert(box_contains(box_grow(cell->box, near), box.min) &&
                  box_contains(box_grow(cell->box, near), box.max));
    }
}

// ---- reference scenes

// Proves that the scene of two rooms comes out as two rooms and a doorway, as they were drawn.
Test(soup, two_rooms) {
    Arena arena = {0};
    const Building *b = soup_fixture_read(&arena, "twoRoom.quads", "two-rooms.quads");
    CellGraph g = soup_make(&arena, b);
    static const Box expected[3] = {
        {{0, 0, 0}, {4, 3, 2.5}}, {{4, 1, 0}, {4.2, 1.9, 2}}, {{4.2, 0, 0}, {8.2, 3, 2.5}}};
    unsigned char indoors[4096];
    int cell[3];
    for (int i = 0; i < 3; i++) {
        cell[i] = vis_locate(&g, vec3_lerp(expected[i].min, expected[i].max, 0.4), -1);
        Box box = g.cells[cell[i]].box;
        // Tolerance: rounding of cuts.
        cr_assert_lt(vec3_length(vec3_sub(box.min, expected[i].min)), 1e-9);
        cr_assert_lt(vec3_length(vec3_sub(box.max, expected[i].max)), 1e-9);
        cr_assert_not(g.cells[cell[i]].outdoors);
    }
    cr_assert_eq(soup_reachable(&g, cell[0], indoors), 3);
    int portals = 0;
    for (int p = 0; p < g.portal_count; p++) portals += indoors[g.portals[p].cell[0]];
    cr_assert_eq(portals, 2);
    cr_assert_eq(g.dropped_slivers, 0);
    soup_check_soup(&g, b, 1, 4000);
    arena_free(&arena);
}

// Proves that furniture stays in the room it stands in.
Test(soup, room_with_boxes) {
    Arena arena = {0};
    const Building *b = soup_fixture_read(&arena, "boxA.quads", "boxes.quads");
    CellGraph g = soup_make(&arena, b);
    unsigned char indoors[4096];
    int cell = vis_locate(&g, vec3(2, 1.5, 1.8), -1);
    cr_assert_eq(soup_reachable(&g, cell, indoors), 1);
    cr_assert_eq(vis_locate(&g, vec3(3, 2, 0.3), -1), cell, "the low box is part of the room");
    soup_check_portals(&g);
    arena_free(&arena);
}

// Proves that houses of many rooms, with slanting roofs, turned any way, are parted without loss.
Test(soup, houses) {
    for (uint64_t seed = 1; seed <= 12; seed++) {
        Arena arena = {0};
        Random random = {seed};
        const Building *b = soup_fixture_house(&arena, &random, 1 + (int)(seed % 4), 1 + (int)(seed % 3));
        if (seed % 2) {
            SoupPose pose = {1, random_between(&random, 0, 6), fixture_direction(&random), {3, -7, 2}};
            b = soup_fixture_posed(&arena, b, &pose);
        }
        CellGraph g = soup_make(&arena, b);
        soup_check_soup(&g, b, seed, 1500);
        check_extents(&g, &random);
        arena_free(&arena);
    }
}

static bool inside_edge(Vec3 p, Vec3 a, Vec3 b, double near) {
    Vec3 along = vec3_sub(b, a), from = vec3_sub(p, a);
    double length = vec3_length(along), t = vec3_dot(from, along) / length;
    return t > near && t < length - near && vec3_length(vec3_sub(from, vec3_scale(along, t / length))) < near;
}

// Proves that what is drawn has no T-vertices, and is what was read otherwise: the same polygons, of the same areas.
// Tolerance: a tenth of what counts as on an edge, of a building of ten metres.
Test(soup, has_no_t_vertices) {
    for (uint64_t seed = 0; seed <= 4; seed++) {
        Arena arena = {0};
        Random random = {seed};
        const Building *b = seed == 0 ? soup_fixture_read(&arena, "twoRoom.quads", "two-rooms.quads")
                                      : soup_fixture_house(&arena, &random, 2, 2);
        CellGraph g = soup_make(&arena, b);
        cr_assert_gt(g.vertex_count, b->vertex_count, "there were some");
        for (int i = 0; i < b->polygon_count; i++) {
            const Polygon *p = &g.polygons[i], *was = &b->polygons[i];
            double area = polygon_area(b->vertices + was->first_vertex, was->vertex_count);
            cr_assert_float_eq(polygon_area(g.vertices + p->first_vertex, p->vertex_count), area, 1e-5);
            for (int k = 0; k < p->vertex_count; k++) {
                Vec3 from = g.vertices[p->first_vertex + k],
                     to = g.vertices[p->first_vertex + (k + 1) % p->vertex_count];
                cr_assert_not(vec3_equal(from, to), "seed %llu, polygon %d: an edge is a point",
                              (unsigned long long)seed, i);
                for (int v = 0; v < g.vertex_count; v++)
                    cr_assert_not(inside_edge(g.vertices[v], from, to, 1e-7), "seed %llu, polygon %d",
                                  (unsigned long long)seed, i);
            }
        }
        arena_free(&arena);
    }
}

// Proves that polygons flung about at random, steep, thin and round ones among them, are parted without a fault, and that
// what hides and what is open is told apart there too.
Test(soup, polygons_at_random) {
    int parted = 0, seeds = support_count(5, 8);
    for (uint64_t seed = 1; seed <= (uint64_t)seeds; seed++) {
        Arena arena = {0};
        Random random = {seed};
        Building *b = soup_fixture_new(&arena);
        for (int i = 0; i < 150; i++) {
            Vec3 n = fixture_direction(&random),
                 u = vec3_normalize(vec3_cross(n, fixture_direction(&random)));
            Vec3 w = vec3_cross(n, u), middle = vec3_scale(fixture_direction(&random), 2);
            double wide = random_between(&random, 0.1, 6),
                   high = seed % 4 ? random_between(&random, 0.1, 6) : 1e-4;
            int corners = 3 + random_index(&random, seed % 3 ? 4 : 28);
            Vec3 v[40];
            for (int k = 0; k < corners; k++) {
                double angle = 2 * M_PI * k / corners;
                v[k] = vec3_add(middle,
                                vec3_add(vec3_scale(u, wide * cos(angle)), vec3_scale(w, high * sin(angle))));
            }
            building_add_polygon(&arena, b, v, corners, 0);
        }
        CellGraph g = soup_make(&arena, b);
        // Where little is hidden, one cell is enough.
        if (g.cell_count > 20) soup_check_soup(&g, b, seed, 500);
        parted += g.cell_count > 20;
        arena_free(&arena);
    }
    cr_assert_gt(parted, seeds / 2 - 1);
}
