// test_query_oracle.c - queries hold what lines from their eyes meet, wherever the eye is.
#include <criterion/criterion.h>

#include "maps/maps.h"
#include "tests/support/fixture.h"
#include "tests/support/prt_scene.h"
#include "tests/support/soup_fixture.h"
#include "tests/support/support.h"
#include "tests/visibility/query/query_fixture.h"
#include "visibility/query/query.h"

// An eye on a portal, to a rasteriser's precision, sees what the cell beyond may see, even where its own may not.
Test(query_oracle, an_eye_on_a_portal_is_in_both_cells) {
    Made m = {0};
    Arena arena = {0};
    Random random = {5};
    int tried = 0;
    query_check_make(&m, query_check_pillars(&arena, &random, 8, 0.3), 5000);
    size_t words = (size_t)m.forest.words;
    uint64_t *row = ARENA_ARRAY(&arena, uint64_t, words);
    for (int p = 0; p < m.graph.portal_count; p++) {
        const Portal *portal = &m.graph.portals[p];
        Vec3 eye =
            vec3_add(query_check_in_portal(&m.graph, portal, &random), vec3_scale(portal->plane.n, 1e-9));
        int here = vis_locate(&m.graph, eye, portal->cell[0]), there = portal->cell[1];
        VisResult before = vis_query(m.query, &(Eye){.position = eye}, here, NULL, CULL_STAB);
        int far = before.cell_count > 0 ? before.cells[before.cell_count - 1].cell : -1;
        if (before.eye_cell != portal->cell[0] || far == here || far == there ||
            !vis_sees(&m.forest, there, far))
            continue;
        memset(row, 0, words * sizeof *row);
        cell_rows_join(&m.forest.seen, here, row);
        row[far / 64] &= ~((uint64_t)1 << (far % 64));
        cell_rows_set(&m.forest.seen, here, row, &arena);
        m.forest.bounded[here] = 1;
        VisResult after = vis_query(m.query, &(Eye){.position = eye}, here, NULL, CULL_STAB);
        cr_assert(query_check_lists(&after, far),
                  "portal %d: cell %d, which %d may see, is not found from %d", p, far, there, here);
        tried++;
    }
    cr_assert_gt(tried, 20);
    arena_free(&m.arena);
    arena_free(&arena);
}

// Proves it of prisms: in an open plan with pillars, where four cells meet in most corners and most rooms are seen through
// two portals, with trees and without (three nodes at most).
Test(query_oracle, prisms) {
    Tally tally = {0};
    for (uint64_t seed = 1; seed <= 12; seed++) {
        Made m = {0};
        Random random = {seed};
        query_check_make(&m, query_check_pillars(&m.arena, &random, 7, 0.1 + 0.03 * (double)(seed % 6)),
                         seed % 2 ? 3 : 100000);
        query_check_check_eyes(&m, 150, false, &random, &tally);
        arena_free(&m.arena);
    }
    cr_assert(tally.lines > 20000 && tally.cells > 2 * tally.lines, "%ld lines, %ld cells", tally.lines,
              tally.cells);
    cr_assert_eq(tally.everything, 0);
}

// Proves it of rooms with doorways and pillars, on two storeys.
Test(query_oracle, rooms) {
    Tally tally = {0};
    for (uint64_t seed = 1; seed <= 8; seed++) {
        Made m = {0};
        Random random = {seed};
        query_check_make(&m, fixture_rooms(&m.arena, &random, 3, 3, 1 + (int)(seed % 2)),
                         seed % 2 ? 3 : 5000);
        query_check_check_eyes(&m, 150, false, &random, &tally);
        arena_free(&m.arena);
    }
    cr_assert_gt(tally.lines, 10000);
}

// Proves that closed doors end the view, with trees and without: behind them nothing is found, before them nothing is lost.
Test(query_oracle, closed_doors) {
    Tally tally = {0};
    for (uint64_t seed = 1; seed <= 8; seed++) {
        Made m = {0};
        Random random = {seed};
        const Building *b = fixture_rooms(&m.arena, &random, 3, 3, 1 + (int)(seed % 2));
        query_check_make(&m, b, seed % 2 ? 3 : 5000);
        m.doors = ARENA_ARRAY(&m.arena, float, b->opening_count);
        for (int i = 0; i < b->opening_count; i++) m.doors[i] = random_index(&random, 3) ? 0 : 0.5f;
        query_check_check_eyes(&m, 100, false, &random, &tally);
        for (int c = 0; c < m.graph.cell_count; c++)
            query_check_check_eye(&m, c, soup_fixture_point(&m.graph, &random, c), CULL_PORTALS, false,
                                  &random, &tally);
        arena_free(&m.arena);
    }
    cr_assert(tally.lines > 10000 && tally.shut > 1000, "%ld lines, %ld pairs", tally.lines, tally.shut);
}

// Proves that an eye where four cells meet, with no wall near, is in one of them and sees all four.
Test(query_oracle, where_four_cells_meet) {
    Made m = {0};
    Random random = {1};
    query_check_make(&m, query_check_pillars(&m.arena, &random, 4, 0), 5000);
    for (int i = 0; i < 9; i++) {
        Eye eye = {.position = vec3(4 + 1e-9 * (i % 3 - 1), 4 + 1e-9 * (i / 3 - 1), 1.6)};
        int cell = vis_locate(&m.graph, eye.position, -1);
        VisResult result = vis_query(m.query, &eye, cell, NULL, CULL_STAB);
        cr_assert_eq(result.eye_cell, cell);
        for (int k = 0; k < 4; k++) {
            Vec3 p = vec3(4 + (k % 2 ? 1 : -1), 4 + (k / 2 ? 1 : -1), 1.6);
            cr_assert(query_check_lists(&result, vis_locate(&m.graph, p, -1)), "eye %d, corner %d", i, k);
        }
    }
    arena_free(&m.arena);
}

// On a surface of the cell, exactly or a millimetre before it at most; or at two surfaces, where they meet; or that far behind them.
static Vec3 at_wall(const CellGraph *g, int cell, double most, Random *random) {
    Plane planes[256];
    Vec3 p = soup_fixture_point(g, random, cell);
    int count = query_check_cell_planes(g, cell, planes), sides = 1 + random_index(random, 2);
    for (int i = 0; i < sides; i++) {
        Plane plane = planes[random_index(random, count)];
        double off = random_index(random, 3) ? most * random_unit(random) : 0;
        p = vec3_add(p, vec3_scale(plane.n, off - plane_distance(plane, p)));
    }
    return p;
}

// Proves that an eye on a wall, within a millimetre of one, in corners and along edges where several cells meet sees all that is seen
// from any cell within that distance, also from rooms on the other side of walls that are no thicker or have no thickness; and that an
// eye in a wall sees all that is seen through the cells around: by trees, by portals and in plan, doors open and closed, straight and
// turned. Never is everything drawn.
Test(query_oracle, at_walls_and_in_them) {
    Tally at = {0}, in = {0};
    for (uint64_t seed = 1; seed <= 16; seed++) {
        Made m = {0};
        Random random = {seed};
        Building *b = seed % 4 == 0   ? query_check_pillars(&m.arena, &random, 6, 0.3)
                      : seed % 4 == 1 ? soup_fixture_house(&m.arena, &random, 3, 2)
                                      : fixture_rooms(&m.arena, &random, 3, 3, 1 + (int)(seed % 2));
        if (seed % 4 == 2) fixture_place(b, (double)seed, vec3(40, -70, 5));
        if (seed % 8 == 5) {
            SoupPose pose = {1, random_between(&random, 0, 6), fixture_direction(&random), {0, 0, 0}};
            b = soup_fixture_posed(&m.arena, b, &pose);
        }
        query_check_make(&m, b, seed % 3 ? 5000 : 3);
        const CellGraph *g = &m.graph;
        m.doors = ARENA_ARRAY(&m.arena, float, b->opening_count + 1);
        for (int i = 0; i < 200; i++) {
            for (int k = 0; k < b->opening_count; k++) m.doors[k] = random_index(&random, 2) ? 0 : 0.5f;
            int cell = random_index(&random, g->cell_count);
            Vec3 p = at_wall(g, cell, i % 2 ? 1e-3 : -0.2, &random);
            cell = vis_locate(g, p, cell);
            query_check_look_from(&m, cell, p, (Culling)(CULL_PORTALS + i % 3), &random,
                                  cell < 0 ? &in : &at);
        }
        arena_free(&m.arena);
    }
    cr_assert(at.lines > 20000 && at.begun > 500 && at.everything == 0, "%ld lines, %ld cells, %ld all",
              at.lines, at.begun, at.everything);
    cr_assert(in.lines > 10000 && in.begun > 500, "%ld lines, %ld cells", in.lines, in.begun);
}

// Proves that an eye outside the building sees everything in its frustum, and nothing behind it.
Test(query_oracle, from_outside_everything_in_the_frustum) {
    Made m = {0};
    Random random = {3};
    query_check_make(&m, query_check_pillars(&m.arena, &random, 5, 0.3), 5000);
    for (int i = 0; i < 100; i++) {
        Vec3 n = fixture_direction(&random);
        Eye eye = {.position =
                       vec3(random_between(&random, -20, -0.01), random_between(&random, -20, 30), 1.6)};
        eye.frustum[eye.frustum_count++] = (Plane){n, vec3_dot(n, eye.position)};
        VisResult result = vis_query(m.query, &eye, -1, NULL, CULL_STAB);
        cr_assert_eq(result.cell_count, 0);
        for (int o = 0, k = 0; o < m.graph.object_count; o++) {
            bool drawn = k < result.object_count && result.objects[k] == o;
            k += drawn;
            Box box = m.graph.object_boxes[o];
            double most = -INFINITY;
            for (int c = 0; c < 8; c++) {
                Vec3 corner = {c & 1 ? box.max.x : box.min.x, c & 2 ? box.max.y : box.min.y,
                               c & 4 ? box.max.z : box.min.z};
                most = fmax(most, plane_distance(eye.frustum[0], corner));
            }
            cr_assert(fabs(most) < 1e-4 || drawn == (most > 0), "eye %d: object %d, %g m before it", i, o,
                      most);
        }
    }
    arena_free(&m.arena);
}

// Proves it of soups, turned any way.
Test(query_oracle, soups) {
    Tally tally = {0};
    for (uint64_t seed = 1; seed <= 8; seed++) {
        Made m = {0};
        Random random = {seed};
        const Building *b = soup_fixture_house(&m.arena, &random, 3, 2);
        if (seed % 2) {
            SoupPose pose = {1, random_between(&random, 0, 6), fixture_direction(&random), {0, 0, 0}};
            b = soup_fixture_posed(&m.arena, b, &pose);
        }
        query_check_make(&m, b, 200);
        const CellGraph *g = &m.graph;
        for (int i = 0; i < 150; i++) {
            int cell = random_index(&random, g->cell_count);
            Vec3 p = i % 3 || g->cells[cell].way_count == 0 ? soup_fixture_point(g, &random, cell)
                                                            : query_check_at_portal(g, cell, &random);
            cell = vis_locate(g, p, cell);
            if (cell >= 0) query_check_check_eye(&m, cell, p, CULL_PORTALS, false, &random, &tally);
        }
        arena_free(&m.arena);
    }
    cr_assert_gt(tally.lines, 20000);
}

// Many small boxes in each room, more than a cell lists.
static void crowd(Building *b, Arena *arena, Random *random, double x, double y) {
    for (int i = 0; i < 60; i++) {
        Vec3 at = {x + random_between(random, 0.1, 3.6), y + random_between(random, 0.1, 3.6),
                   random_between(random, 0, 2.4)};
        double size = random_between(random, 0.02, 0.3), turn = random_unit(random);
        building_add_object(arena, b, OBJECT_FURNITURE, "box");
        for (int k = 0; k < 2; k++) {
            Vec3 u = {size * cos(turn), size * sin(turn), 0}, v = k ? vec3(0, 0, size) : vec3(-u.y, u.x, 0);
            Vec3 quad[4] = {at, vec3_add(at, u), vec3_add(vec3_add(at, u), v), vec3_add(at, v)};
            building_add_polygon(arena, b, quad, 4, 0);
        }
    }
}

// Before all of an upright portal, as seen from the eye, does a box lie clear of it, beside, over or under, by more than a hand's width?
static bool lies_beside(const CellGraph *g, const Portal *portal, Vec3 eye, Box box) {
    const Vec3 *v = g->portal_vertices + portal->first_vertex;
    for (int i = 0; i < portal->vertex_count; i++) {
        Vec3 middle = vec3_lerp(v[0], v[2], 0.5);
        Vec3 n =
            vec3_normalize(vec3_cross(vec3_sub(v[i], eye), vec3_sub(v[(i + 1) % portal->vertex_count], eye)));
        if (vec3_dot(n, vec3_sub(middle, eye)) < 0) n = vec3_scale(n, -1);
        bool outside = true;
        for (int k = 0; k < 8; k++) {
            Vec3 corner = {k & 1 ? box.max.x : box.min.x, k & 2 ? box.max.y : box.min.y,
                           k & 4 ? box.max.z : box.min.z};
            outside = outside && vec3_dot(n, vec3_sub(corner, eye)) < -0.1;
        }
        if (outside) return true;
    }
    return false;
}

// Proves that of rooms with more objects than are tried one by one nothing is lost that a straight line from the eye comes to, and that
// of a room beyond one doorway nothing is drawn that lies beside the view through that: straight, at a slant, far from the origin, with
// narrow squares and wide.
Test(query_oracle, crowded_rooms) {
    long seen = 0, hidden = 0;
    for (uint64_t seed = 1; seed <= 8; seed++) {
        Made m = {0};
        Random random = {seed};
        Building *b = fixture_rooms(&m.arena, &random, 3, 2, 1);
        for (int i = 0; i < 6; i++) crowd(b, &m.arena, &random, i % 3 * 4.2, i / 3 * 4.2);
        fixture_place(b, seed % 2 ? 0 : 0.7 * (double)seed, vec3(-300, 45.5 * (double)seed, 3));
        query_check_make(&m, b, 5000);
        const CellGraph *g = &m.graph;
        unsigned char *drawn = ARENA_ARRAY(&m.arena, unsigned char, g->object_count);
        for (int i = 0; i < 60; i++) {
            int cell = random_index(&random, g->cell_count);
            Eye eye = {.position = fixture_point(g, &random, cell)};
            if (i % 2) {
                Vec3 n = fixture_direction(&random);
                eye.frustum[eye.frustum_count++] = (Plane){n, vec3_dot(n, eye.position)};
            }
            Culling culling = (Culling)(CULL_PORTALS + i % 3);
            VisResult result = vis_query(m.query, &eye, cell, NULL, culling);
            memset(drawn, 0, (size_t)g->object_count);
            for (int k = 0; k < result.object_count; k++) drawn[result.objects[k]] = 1;
            for (int o = 0; o < g->surface_first[0]; o++) {
                const Polygon *p = &g->polygons[g->objects[o].first_polygon];
                Vec3 at = g->vertices[p->first_vertex + random_index(&random, p->vertex_count)],
                     way = vec3_sub(at, eye.position);
                double far = vec3_length(way);
                Trace trace;
                bool in_view = eye.frustum_count == 0 || vec3_dot(eye.frustum[0].n, way) > 1e-6;
                if (!in_view || far < 0.1) continue;
                if (!fixture_trace(g, cell, eye.position, vec3_scale(way, 1 / far), NULL, &trace)) continue;
                if (vec3_length(vec3_sub(trace.hit, eye.position)) < far) continue;
                seen++;
                cr_assert(drawn[o], "seed %llu, %s: object %d, seen at (%g, %g, %g), is not drawn",
                          (unsigned long long)seed, CULLING_NAMES[culling], o, at.x, at.y, at.z);
            }
            // Beyond a portal of the eye's cell that is its only one.
            if (g->cells[cell].way_count != 1 || culling == CULL_PLAN) continue;
            const Portal *portal = &g->portals[g->ways[g->cells[cell].first_way].portal];
            if (fabs(plane_distance(portal->plane, eye.position)) < 0.5) continue;
            for (int o = 0; o < g->surface_first[0]; o++) {
                if (box_overlap(box_grow(g->object_boxes[o], 0.01), g->cells[cell].box)) continue;
                bool beside = lies_beside(g, portal, eye.position, g->object_boxes[o]);
                hidden += beside;
                cr_assert(!beside || !drawn[o], "seed %llu: object %d lies beside the view",
                          (unsigned long long)seed, o);
            }
        }
        arena_free(&m.arena);
    }
    cr_assert(seen > 10000 && hidden > 500, "%ld seen, %ld hidden", seen, hidden);
}

// Proves it of given cells, whose walls nobody knows: eyes in portals are in the cell they are said to be in.
Test(query_oracle, given_cells, .timeout = 120) {
    static const char *const files[] = {"lqdm2_omitdetail", "dm4"};
    static const char *const homes[] = {"build/maps/hillside.sh3d", "build/maps/villa.sh3d"};
    for (int f = 0; f < 2; f++) {
        Made m = {0};
        Tally tally = {0};
        Random random = {(uint64_t)f + 1};
        Building b;
        Error error = {""};
        cr_assert(maps_read(prt_file(&m.arena, files[f], homes[f]), &m.arena, &b, &error), "%s", error.text);
        query_check_make(&m, &b, 100);
        const CellGraph *g = &m.graph;
        for (int i = 0; i < support_count(150, 2000); i++) {
            int cell = random_index(&random, g->cell_count);
            if (g->cells[cell].way_count == 0) continue;
            query_check_check_eye(&m, cell, query_check_at_portal(g, cell, &random), CULL_PORTALS, true,
                                  &random, &tally);
        }
        cr_assert(tally.lines > 1000 && tally.everything == 0, "%ld lines, all is drawn for %ld eyes",
                  tally.lines, tally.everything);
        arena_free(&m.arena);
    }
}
