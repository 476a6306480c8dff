// test_query.c - the cells a query finds, against straight lines from the eye through portals, where it is hardest: eyes on
// portals, a hair's breadth off them, and in corners where cells meet; in prisms, given cells and soups.
#include <criterion/criterion.h>

#include "tests/support/fixture.h"
#include "tests/support/soup_fixture.h"
#include "tests/support/support.h"
#include "tests/visibility/query/query_fixture.h"
#include "visibility/query/query.h"

// ---- which cells an eye is in

// How far a point is from a convex polygon: from its plane over it, from its edges beside it.
static double from_polygon(const Vec3 *v, int count, Vec3 p) {
    Plane plane = plane_of_polygon(v, count);
    double nearest = INFINITY;
    bool over = true;
    for (int i = 0; i < count; i++) {
        Vec3 edge = vec3_sub(v[(i + 1) % count], v[i]), to = vec3_sub(p, v[i]);
        double t = fmin(fmax(vec3_dot(to, edge) / vec3_dot(edge, edge), 0), 1);
        nearest = fmin(nearest, vec3_length(vec3_sub(to, vec3_scale(edge, t))));
        over = over && vec3_dot(vec3_cross(plane.n, edge), to) >= 0;
    }
    return over ? fabs(plane_distance(plane, p)) : nearest;
}

static double from_portal(const CellGraph *g, int portal, Vec3 p) {
    const Portal *at = &g->portals[portal];
    return from_polygon(g->portal_vertices + at->first_vertex, at->vertex_count, p);
}

// Somewhere in a cell, and mostly near one of its planes, or of two of them, at distances of all sizes; or as far beyond them.
static Vec3 near_sides(const CellGraph *g, int cell, Random *random, bool beyond) {
    Plane planes[256];
    Vec3 p = soup_fixture_point(g, random, cell);
    int count = query_check_cell_planes(g, cell, planes), sides = random_index(random, 3);
    if (random_index(random, 3) == 0 && g->cells[cell].way_count > 0)
        p = query_check_at_portal(g, cell, random);
    for (int i = 0; i < sides; i++) {
        Plane plane = planes[random_index(random, count)];
        double off = pow(10, random_between(random, -6.5, -1)) * (beyond ? -5 : 1);
        p = vec3_add(p, vec3_scale(plane.n, off - plane_distance(plane, p)));
    }
    return p;
}

static bool is_among(const int *cells, int count, int cell) {
    for (int i = 0; i < count; i++)
        if (cells[i] == cell) return true;
    return false;
}

typedef struct EyeTally {
    int alone, joined, on_surface, in_wall;
} EyeTally;

// These are the cells within `near` of the point, but for its own, which is the first; in doubt within a hundredth.
static void check_near(const CellGraph *g, int cell, Vec3 p, double near, const int *cells, int count) {
    for (int c = 0; c < g->cell_count; c++) {
        double off = query_check_outside(g, c, p);
        bool listed = is_among(cells, count, c),
             close = box_contains(box_grow(g->cells[c].box, 0.99 * near), p);
        cr_assert(!listed || c == cell || off < 1.01 * near, "cell %d is %g m from (%.9g, %.9g, %.9g)", c,
                  off, p.x, p.y, p.z);
        cr_assert(listed || !close || off >= 0.99 * near || count == 0, "cell %d is near (%.9g, %.9g, %.9g)",
                  c, p.x, p.y, p.z);
    }
    for (int i = 0; i < count; i++) cr_assert(!is_among(cells, i, cells[i]), "a cell is there twice");
}

// All three limits as query.h and query_eye.c have them: a millimetre through walls, a quarter of a metre for an eye in none of the cells,
// POSITION_SLACK to portals for an eye on a surface. Portals are told by boxes around them, which at a slant are larger than these.
static void check_eye_cells(const CellGraph *g, int cell, Vec3 p, EyeTally *tally) {
    int cells[MOST_AROUND];
    for (int i = 0; i < MOST_AROUND; i++) cells[i] = -1;
    int count = query_eye_cells(g, cell, &(Eye){.position = p}, cells);
    if (cell < 0) {
        if (count > 0 || box_contains(g->box, p)) check_near(g, -1, p, 0.25, cells, count);
        tally->in_wall += count > 0;
        cr_assert_eq(query_eye_cells(g, cell, &(Eye){.position = p, .on_surface = true}, cells), 0);
        return;
    }
    cr_assert(count > 0 && cells[0] == cell, "its own comes first");
    check_near(g, cell, p, 1e-3, cells, count);
    tally->joined += count > 1;
    tally->alone += count == 1;
    count = query_eye_cells(g, cell, &(Eye){.position = p, .on_surface = true}, cells);
    cr_assert(count > 0 && cells[0] == cell, "its own comes first");
    for (int i = 0; i < count; i++) {
        cr_assert(!is_among(cells, i, cells[i]), "a cell is there twice");
        cr_assert(box_contains(box_grow(g->cells[cells[i]].box, 1.01 * POSITION_SLACK), p),
                  "it is not in cell %d", cells[i]);
        const Cell *c = &g->cells[cells[i]];
        for (int k = c->first_way; k < c->first_way + c->way_count; k++)
            cr_assert(is_among(cells, count, g->ways[k].cell) ||
                          from_portal(g, g->ways[k].portal, p) >= 0.99 * POSITION_SLACK,
                      "(%.9g, %.9g, %.9g) in cell %d is in cell %d as well", p.x, p.y, p.z, cell,
                      g->ways[k].cell);
    }
    tally->on_surface += count > 1;
}

// Proves in which cells the view of an eye begins: against the distances to all cells and portals, in rooms straight and at a slant, in
// an open plan and in soups, in free space and in walls.
Test(query_eye, cells_are_told_by_distance) {
    EyeTally tally = {0};
    for (uint64_t seed = 1; seed <= 12; seed++) {
        Made m = {0};
        Random random = {seed};
        Building *b = seed % 4 == 0   ? query_check_pillars(&m.arena, &random, 5, 0.2)
                      : seed % 4 == 1 ? soup_fixture_house(&m.arena, &random, 2, 2)
                                      : fixture_rooms(&m.arena, &random, 2, 2, 2);
        if (seed % 4 > 1) fixture_place(b, seed % 4 == 2 ? 0 : (double)seed, vec3(40, -70, 5));
        query_check_make(&m, b, 3);
        cr_assert_lt(m.graph.cell_count, 512);
        for (int i = 0; i < 1500; i++) {
            int cell = random_index(&random, m.graph.cell_count);
            Vec3 p = near_sides(&m.graph, cell, &random, i % 3 == 0);
            check_eye_cells(&m.graph, vis_locate(&m.graph, p, cell), p, &tally);
        }
        arena_free(&m.arena);
    }
    cr_assert(tally.alone > 2000 && tally.joined > 1000 && tally.on_surface > 500 && tally.in_wall > 1000,
              "%d alone, %d joined, %d on surfaces, %d in walls", tally.alone, tally.joined, tally.on_surface,
              tally.in_wall);
}

// Proves that what goes on through a portal in whose plane the eye is holds all that is seen through it, with a millimetre on either
// side of its plane, and not much more: slits as high as rooms and as narrow as a jamb, seen from beside their foot. Tolerance: the
// planes stand within a fifth of the portal's.
Test(query_cone, edge_on_holds_all_of_the_portal) {
    int kept = 0;
    for (uint64_t seed = 1; seed <= 20000; seed++) {
        Random random = {seed};
        Vec3 n = fixture_direction(&random), u = vec3_normalize(vec3_cross(n, fixture_direction(&random)));
        Vec3 v = vec3_cross(n, u), eye = {3, -2, 1}, corner[4];
        double width = pow(10, random_between(&random, -2, 1)),
               height = pow(10, random_between(&random, -2, 1));
        double beside = pow(10, random_between(&random, -2, 1)), foot = random_between(&random, -height, 0);
        double off = random_between(&random, -1, 1) * ON_PLANE;
        for (int k = 0; k < 4; k++) {
            double x = beside + (k == 1 || k == 2 ? width : 0), y = foot + (k > 1 ? height : 0);
            corner[k] =
                vec3_add(vec3_add(eye, vec3_scale(n, off)), vec3_add(vec3_scale(u, x), vec3_scale(v, y)));
        }
        VisQuery query = {.eye = &(Eye){.position = eye}, .culling = CULL_STAB};
        ViewWay way = {.plane = {n, vec3_dot(n, corner[0])}, .ahead = -off};
        ViewPart part = {.polygon = corner, .count = 4};
        Cone before = {.count = 0}, beyond;
        query_beyond(&query, &before, PASSAGE_EDGE, &way, &part, &beyond);
        kept += beyond.count > 0;
        cr_assert_not(beyond.is_slot);
        double length = 0;
        for (int k = 0; k < 4; k++) length = fmax(length, vec3_length(vec3_sub(corner[k], eye)));
        for (int i = 0; i < beyond.count; i++) {
            double nearest = INFINITY;
            for (int k = 0; k < 4; k++) nearest = fmin(nearest, plane_distance(beyond.plane[i], corner[k]));
            cr_assert(nearest > 0.8 * ON_PLANE && nearest < 3.2 * ON_PLANE + ANGLE_SLACK * length,
                      "seed %d: %g m, of %g x %g m, %g beside", (int)seed, nearest, width, height, beside);
        }
    }
    cr_assert_gt(kept, 10000);
}

// The portal's corners, moved outwards by half the slack, are in the wedge; and no farther than twice all slack lies its edge from
// the outermost of them.
static void check_wedge(const Cone *cone, Vec3 eye, const Vec3 *corner, int count, int seed) {
    double aside[2] = {INFINITY, INFINITY}, nearest = INFINITY;
    Vec2 edge[2] = {vec2_scale(cone->from, 1 / vec2_length(cone->from)),
                    vec2_scale(cone->to, -1 / vec2_length(cone->to))};
    for (int k = 0; k < count; k++) {
        Vec2 d = vec2(corner[k].x - eye.x, corner[k].y - eye.y);
        nearest = fmin(nearest, vec2_length(d));
        for (int side = 0; side < 2; side++) {
            double off = vec2_cross(edge[side], d);
            cr_assert_geq(off, POSITION_SLACK / 2 + ANGLE_SLACK / 2 * vec2_length(d),
                          "seed %d: corner %d, side %d", seed, k, side);
            aside[side] = fmin(aside[side], off / vec2_length(d));
        }
    }
    for (int side = 0; side < 2; side++)
        cr_assert_leq(aside[side], 2 * (ANGLE_SLACK + POSITION_SLACK / nearest),
                      "seed %d: side %d is too wide", seed, side);
}

// Proves that the volume beyond a portal of any outline holds all of it and the slack around, in plan and in space, and no more
// than twice the slack.
Test(query_cone, part_holds_the_portal_and_its_slack) {
    int wedges = 0, planes = 0;
    for (int seed = 1; seed <= 20000; seed++) {
        Random random = {(uint64_t)seed};
        Vec3 eye = {5, -7, 1.6}, middle = {0, 0, 0}, ahead = fixture_direction(&random), corner[8];
        Vec3 x = vec3_normalize(vec3_cross(ahead, fixture_direction(&random))), y = vec3_cross(ahead, x);
        double size = pow(10, random_between(&random, -1.5, 0.5)),
               far = random_between(&random, 1.2, 20) * size;
        int count = 3 + random_index(&random, 6);
        for (int k = 0; k < count; k++) {
            double turn = 2 * M_PI * (k + random_between(&random, -0.3, 0.3)) / count;
            Vec3 off = vec3_add(vec3_scale(x, size * cos(turn)), vec3_scale(y, size * sin(turn)));
            corner[k] = vec3_add(vec3_add(eye, vec3_scale(ahead, far)), off);
            middle = vec3_add(middle, vec3_scale(vec3_sub(corner[k], eye), 1.0 / count));
        }
        CellView nothing_listed = {0};
        VisQuery query = {.eye = &(Eye){.position = eye}, .of_cell = &nothing_listed};
        ViewWay way = {.plane = {ahead, vec3_dot(ahead, corner[0])}, .ahead = far};
        ViewPart part = {.polygon = corner, .count = count, .middle = middle, .distance = far};
        Cone before = {.count = 0}, beyond;
        query.culling = CULL_PLAN;
        query_beyond(&query, &before, PASSAGE_PART, &way, &part, &beyond);
        wedges += !beyond.all_around;
        if (!beyond.all_around) check_wedge(&beyond, eye, corner, count, seed);
        cr_assert_eq(beyond.count, beyond.all_around ? 0 : 2);
        query.culling = CULL_STAB;
        query_beyond(&query, &before, PASSAGE_PART, &way, &part, &beyond);
        cr_assert_eq(beyond.count, count, "a plane for each edge");
        for (int i = 0; i < beyond.count; i++, planes++) {
            double least = INFINITY;
            for (int k = 0; k < count; k++) least = fmin(least, plane_distance(beyond.plane[i], corner[k]));
            double slack = POSITION_SLACK + ANGLE_SLACK * far;
            cr_assert(least > slack / 2 && least < 4 * slack, "seed %d: %g from plane %d, slack %g", seed,
                      least, i, slack);
        }
    }
    cr_assert(wedges > 8000 && planes > 60000, "%d wedges, %d planes", wedges, planes);
}
