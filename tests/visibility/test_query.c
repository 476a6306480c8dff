// test_query.c - the cells a query finds, against straight lines from the eye through portals, where it is hardest: eyes on
// portals, a hair's breadth off them, and in corners where cells meet; in prisms, given cells and soups.
#include <criterion/criterion.h>
#include <stdlib.h>

#include "maps/maps.h"
#include "tests/support/fixture.h"
#include "tests/support/prt_scene.h"
#include "tests/support/soup_fixture.h"
#include "tests/support/support.h"
#include "visibility/query/query.h"

typedef struct Made {
    Arena arena;
    const Building *building;
    CellGraph graph;
    StabForest forest;
    VisQuery *query;
    float *doors;  // [opening_count] or NULL: all open
} Made;

static void make(Made *m, const Building *b, int max_nodes) {
    VisOptions options = vis_default_options();
    options.max_nodes = max_nodes;
    Error error = {""};
    m->building = b;
    cr_assert(vis_build_cells(b, &options, &m->arena, &m->graph, &error), "%s", error.text);
    cr_assert(vis_build_forest(&m->graph, &options, NULL, &m->arena, &m->forest));
    m->query = vis_query_new(&m->graph, &m->forest, &m->arena);
}

// An open plan: n x n squares of 2 m, of which a share is solid, with floors and ceilings of several heights. Four cells meet
// in most corners, and most ways lead round pillars.
static Building *pillars(Arena *arena, Random *random, int n, double solid) {
    static const double SIDE = 2;
    Building *b = ARENA_ARRAY(arena, Building, 1);
    b->source = "pillars";
    building_add_material(arena, b,
                          (Material){.name = "stone", .reflectance = {0.5f, 0.5f, 0.5f}, .alpha = 1});
    for (int i = 0; i < n * n; i++) {
        double floor = 0.1 * random_index(random, 4), ceiling = 3 + 0.2 * random_index(random, 4);
        if (random_unit(random) < solid) continue;
        *ARENA_PUSH(arena, b->regions, b->region_count, b->region_capacity) =
            (Region){.name = "",
                     .storey = -1,
                     .opening = -1,
                     .first_ring = b->ring_count,
                     .ring_count = 1,
                     .z0 = floor,
                     .z1 = ceiling};
        *ARENA_PUSH(arena, b->rings, b->ring_count, b->ring_capacity) = (Ring){b->point_count, 4};
        double x = i % n * SIDE, y = i / n * SIDE;
        const Vec2 ring[4] = {{x, y}, {x + SIDE, y}, {x + SIDE, y + SIDE}, {x, y + SIDE}};
        for (int k = 0; k < 4; k++) {
            int at = b->point_count;
            *ARENA_PUSH(arena, b->edge_material, at, b->edge_capacity) = 0;
            *ARENA_PUSH(arena, b->points, b->point_count, b->point_capacity) = ring[k];
        }
    }
    b->world = (Box){{0, 0, 0}, {n * SIDE, n * SIDE, 4}};
    return b;
}

// ---- lines

// The planes that bound a cell, pointing inwards.
static int cell_planes(const CellGraph *g, int c, Plane *out) {
    const Cell *cell = &g->cells[c];
    int count = 0;
    for (int i = 0; i < cell->face_count; i++) out[count++] = g->faces[cell->first_face + i];
    if (cell->face_count > 0) return count;
    out[count++] = (Plane){{0, 0, 1}, cell->z0};
    out[count++] = (Plane){{0, 0, -1}, -cell->z1};
    for (int i = 0; i < cell->edge_count; i++) {
        Vec2 a = g->plan[cell->first_edge + i], b = g->plan[cell->first_edge + (i + 1) % cell->edge_count];
        Vec3 n = vec3_normalize(vec3(a.y - b.y, b.x - a.x, 0));
        out[count++] = (Plane){n, n.x * a.x + n.y * a.y};
    }
    return count;
}

typedef struct Line {
    Vec3 from, way;
    const float *doors;  // closed ones end it
    int cells[512];      // that it enters, in order
    int count;
} Line;

// Lines nearer than this to an edge of a portal are given up: rounding decides them. Metres.
static const double DOUBTFUL = 1e-6;

// Where the line leaves the cell, or -1 where it is in it for no stretch worth the name after `after`.
static double leaves_at(const CellGraph *g, int c, const Line *line, double after) {
    Plane planes[256];
    double in = after, out = INFINITY;
    int count = cell_planes(g, c, planes);
    for (int i = 0; i < count; i++) {
        double off = plane_distance(planes[i], line->from), rate = vec3_dot(planes[i].n, line->way);
        if (rate > 0) in = fmax(in, -off / rate);
        if (rate < 0) out = fmin(out, -off / rate);
        if (rate == 0 && off < 0) return -1;
    }
    return out > in + 10 * DOUBTFUL && in < after + DOUBTFUL ? out : -1;
}

static bool is_closed(const Portal *portal, const float *doors) {
    return portal->door >= 0 && doors && doors[portal->door] == 0;
}

// Follows the line through cells as they are bounded, from whichever holds its beginning. False: given up.
static bool follow(const CellGraph *g, Line *line) {
    double at = 0;
    int cell = -1;
    line->count = 0;
    for (int c = 0; c < g->cell_count && cell < 0; c++) {
        if (box_contains(box_grow(g->cells[c].box, 1e-5), line->from) && leaves_at(g, c, line, 0) > 0)
            cell = c;
    }
    while (cell >= 0 && line->count < 512) {
        line->cells[line->count++] = cell;
        at = leaves_at(g, cell, line, at);
        if (!isfinite(at)) return true;
        Vec3 p = vec3_add(line->from, vec3_scale(line->way, at));
        const Cell *here = &g->cells[cell];
        int next = -1;
        for (int i = here->first_way; i < here->first_way + here->way_count; i++) {
            const Portal *portal = &g->portals[g->ways[i].portal];
            if (fabs(plane_distance(portal->plane, p)) > DOUBTFUL || is_closed(portal, line->doors)) continue;
            int inside = soup_fixture_inside(g->portal_vertices + portal->first_vertex, portal->vertex_count,
                                             p, 2 * DOUBTFUL);
            if (inside < 0) return false;
            if (inside > 0 && leaves_at(g, g->ways[i].cell, line, at) > 0) next = g->ways[i].cell;
        }
        cell = next;
    }
    return true;
}

// Follows the line by the portals it pierces alone, from a cell that is told: of given cells no walls are known.
static bool pierce(const CellGraph *g, int cell, Line *line) {
    line->count = 0;
    while (cell >= 0 && line->count < 512) {
        line->cells[line->count++] = cell;
        const Cell *here = &g->cells[cell];
        int next = -1;
        for (int i = here->first_way; i < here->first_way + here->way_count; i++) {
            const Portal *portal = &g->portals[g->ways[i].portal];
            double side = portal->cell[0] == cell ? -1 : 1,
                   rate = side * vec3_dot(portal->plane.n, line->way);
            double t = -side * plane_distance(portal->plane, line->from) / rate;
            if (rate < 1e-3 || t < -DOUBTFUL) continue;
            Vec3 p = vec3_add(line->from, vec3_scale(line->way, t));
            // Corners of given portals lie up to 3 mm off their plane, which their outline turns with.
            int inside =
                soup_fixture_inside(g->portal_vertices + portal->first_vertex, portal->vertex_count, p, 4e-3);
            if (inside < 0) return false;
            if (inside > 0) next = g->ways[i].cell;
        }
        cell = next;
    }
    return true;
}

static bool lists(const VisResult *result, int cell) {
    for (int i = 0; i < result->cell_count; i++) {
        if (result->cells[i].cell == cell) return true;
    }
    return false;
}

// ---- eyes

// A convex mix of a portal's corners, at random on its edges too.
static Vec3 in_portal(const CellGraph *g, const Portal *portal, Random *random) {
    Vec3 sum = {0, 0, 0};
    double weights = 0;
    bool on_edge = random_unit(random) < 0.2;
    int first = random_index(random, portal->vertex_count);
    for (int i = 0; i < portal->vertex_count; i++) {
        double w = on_edge && i > 1 ? 0 : random_unit(random);
        const Vec3 *v = g->portal_vertices + portal->first_vertex;
        sum = vec3_add(sum, vec3_scale(v[(first + i) % portal->vertex_count], w));
        weights += w;
    }
    return vec3_scale(sum, 1 / weights);
}

// On a portal of a cell, or 1e-9 m before or behind it.
static Vec3 at_portal(const CellGraph *g, int cell, Random *random) {
    const Cell *c = &g->cells[cell];
    const Portal *portal = &g->portals[g->ways[c->first_way + random_index(random, c->way_count)].portal];
    Vec3 p = in_portal(g, portal, random);
    return vec3_add(p, vec3_scale(portal->plane.n, 1e-9 * (random_index(random, 3) - 1)));
}

// In a corner of a cell's plan, or at its sides, at the height of an eye.
static Vec3 at_corner(const CellGraph *g, int cell, Random *random) {
    const Cell *c = &g->cells[cell];
    Vec2 p = g->plan[c->first_edge + random_index(random, c->edge_count)];
    double off = random_index(random, 2) ? 1e-9 : 0;
    return vec3(p.x + off * (random_index(random, 3) - 1), p.y + off * (random_index(random, 3) - 1),
                (c->z0 + c->z1) / 2);
}

typedef struct Tally {
    long lines, cells, eyes, outside;
    long shut;  // pairs of a cell and one that only closed doors hide from it
} Tally;

// Is the cell in the visible set of the eye's cell, or of another that it is in to a rasteriser's precision, 2e-5 m?
static bool may_see(const Made *m, int eye_cell, Vec3 eye, int cell) {
    if (vis_sees(&m->forest, eye_cell, cell)) return true;
    for (int c = 0; c < m->graph.cell_count; c++) {
        if (vis_sees(&m->forest, c, cell) && box_contains(box_grow(m->graph.cells[c].box, 2e-5), eye))
            return true;
    }
    return false;
}

// Cells that a way without closed doors leads to from those which the eye is in.
static unsigned char *reachable(const Made *m, Vec3 eye, Arena *arena) {
    const CellGraph *g = &m->graph;
    unsigned char *reached = ARENA_ARRAY(arena, unsigned char, g->cell_count);
    for (int c = 0; c < g->cell_count; c++) reached[c] = box_contains(box_grow(g->cells[c].box, 2e-5), eye);
    for (bool more = true; more;) {
        more = false;
        for (int p = 0; p < g->portal_count; p++) {
            const int *cell = g->portals[p].cell;
            if (is_closed(&g->portals[p], m->doors) || reached[cell[0]] == reached[cell[1]]) continue;
            reached[cell[0]] = reached[cell[1]] = more = true;
        }
    }
    return reached;
}

// All cells that lines from the eye enter are found, and none but those that the eye's cell may see.
static void check_eye(Made *m, int cell, Vec3 position, Culling culling, bool given, Random *random,
                      Tally *tally) {
    const CellGraph *g = &m->graph;
    Eye eye = {.position = position};
    VisResult result = vis_query(m->query, &eye, cell, m->doors, culling);
    tally->eyes++;
    tally->outside += result.eye_cell < 0;
    if (result.eye_cell < 0) return;  // all is drawn
    for (int i = 0; i < result.cell_count && culling != CULL_PORTALS; i++)
        cr_assert(may_see(m, cell, position, result.cells[i].cell), "cell %d is not in the visible set of %d",
                  result.cells[i].cell, cell);
    Arena scratch = {0};
    const unsigned char *reached = reachable(m, position, &scratch);
    for (int i = 0; i < result.cell_count; i++)
        cr_assert(reached[result.cells[i].cell], "%s: cell %d is found from %d behind closed doors",
                  CULLING_NAMES[culling], result.cells[i].cell, cell);
    for (int c = 0; c < g->cell_count; c++) tally->shut += !reached[c] && vis_sees(&m->forest, cell, c);
    arena_free(&scratch);
    for (int k = 0; k < 60; k++) {
        Line line = {.from = position, .way = fixture_direction(random), .doors = m->doors};
        line.way.z *= given ? 1 : 0.2;
        if (!(given ? pierce(g, cell, &line) : follow(g, &line))) continue;
        // From another cell that the eye is in to a hair, a closed door may lie between.
        if (m->doors && line.count > 0 && line.cells[0] != cell) continue;
        tally->lines++;
        tally->cells += line.count;
        for (int i = 0; i < line.count; i++)
            cr_assert(
                lists(&result, line.cells[i]),
                "%s: eye (%.12g, %.12g, %.12g) in cell %d sees cell %d (%d on its line), which is not found",
                CULLING_NAMES[culling], position.x, position.y, position.z, cell, line.cells[i], i);
    }
}

static void check_eyes(Made *m, int eyes, bool given, Random *random, Tally *tally) {
    const CellGraph *g = &m->graph;
    for (int i = 0; i < eyes; i++) {
        int cell = random_index(random, g->cell_count);
        if (g->cells[cell].way_count == 0) continue;
        Vec3 p = i % 3 == 0 && !given ? at_corner(g, cell, random) : at_portal(g, cell, random);
        if (!given) cell = vis_locate(g, p, cell);
        if (cell < 0) continue;
        check_eye(m, cell, p, i % 2 ? CULL_STAB : CULL_PORTALS, given, random, tally);
    }
}

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

// How far the nearest wall is of what bounds these cells; of a soup, of all that is drawn.
static double from_walls(const CellGraph *g, const int *cells, int count, Vec3 p) {
    double nearest = INFINITY;
    for (int o = 0; o < g->object_count; o++) {
        bool here = g->cells[0].face_count > 0;
        for (int i = 0; i < count && !here; i++)
            here = o >= g->surface_first[cells[i]] && o < g->surface_first[cells[i] + 1];
        for (int k = 0; here && k < g->objects[o].polygon_count; k++) {
            const Polygon *polygon = &g->polygons[g->objects[o].first_polygon + k];
            nearest =
                fmin(nearest, from_polygon(g->vertices + polygon->first_vertex, polygon->vertex_count, p));
        }
    }
    return nearest;
}

// Somewhere in a cell, and mostly near one of its planes, or of two of them, at distances of all sizes.
static Vec3 near_sides(const CellGraph *g, int cell, Random *random) {
    Plane planes[256];
    Vec3 p = soup_fixture_point(g, random, cell);
    int count = cell_planes(g, cell, planes), sides = random_index(random, 3);
    if (random_index(random, 3) == 0 && g->cells[cell].way_count > 0) p = at_portal(g, cell, random);
    for (int i = 0; i < sides; i++) {
        Plane plane = planes[random_index(random, count)];
        double off = pow(10, random_between(random, -6.5, -1));
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
    int alone, joined, at_wall;
} EyeTally;

// Both limits as query.h and query_eye.c have them: a millimetre to walls, POSITION_SLACK to portals. Cells are told by boxes around
// portals, which at a slant are larger than these.
static void check_eye_cells(const CellGraph *g, int cell, Vec3 p, EyeTally *tally) {
    static const double CLEARANCE = 1e-3;
    int cells[MOST_AROUND], around[MOST_AROUND], near = 0;
    for (int i = 0; i < MOST_AROUND; i++) cells[i] = -1;
    int count = query_eye_cells(g, cell, &(Eye){.position = p}, cells);
    // The cells nearer than the clearance, by portals nearer than that.
    around[near++] = cell;
    for (int i = 0; i < near; i++) {
        const Cell *c = &g->cells[around[i]];
        for (int k = c->first_way; k < c->first_way + c->way_count && near < MOST_AROUND; k++)
            if (from_portal(g, g->ways[k].portal, p) < 0.99 * CLEARANCE &&
                !is_among(around, near, g->ways[k].cell))
                around[near++] = g->ways[k].cell;
    }
    if (from_walls(g, around, near, p) < 0.99 * CLEARANCE) {
        cr_assert_eq(count, 0, "(%.9g, %.9g, %.9g) in cell %d is at a wall", p.x, p.y, p.z, cell);
        int told = query_eye_cells(g, cell, &(Eye){.position = p, .on_surface = true}, cells);
        cr_assert(told > 0 && cells[0] == cell, "on a surface it is before it");
        tally->at_wall++;
        return;
    }
    int every[512];
    for (int c = 0; c < g->cell_count; c++) every[c] = c;
    cr_assert(count > 0 || from_walls(g, every, g->cell_count, p) < 3 * CLEARANCE,
              "(%.9g, %.9g, %.9g) in cell %d is far from any wall", p.x, p.y, p.z, cell);
    if (count == 0) return;
    cr_assert_eq(cells[0], cell, "its own comes first");
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
    tally->joined += count > 1;
    tally->alone += count == 1;
}

// Proves which cells an eye is in, to a rasteriser's precision, and when it is too near a wall: against the distances to all walls and
// portals, in rooms straight and at a slant, in an open plan and in soups.
Test(query_eye, cells_are_told_by_distance) {
    EyeTally tally = {0};
    for (uint64_t seed = 1; seed <= 12; seed++) {
        Made m = {0};
        Random random = {seed};
        Building *b = seed % 4 == 0   ? pillars(&m.arena, &random, 5, 0.2)
                      : seed % 4 == 1 ? soup_fixture_house(&m.arena, &random, 2, 2)
                                      : fixture_rooms(&m.arena, &random, 2, 2, 2);
        if (seed % 4 > 1) fixture_place(b, seed % 4 == 2 ? 0 : (double)seed, vec3(40, -70, 5));
        make(&m, b, 3);
        cr_assert_lt(m.graph.cell_count, 512);
        for (int i = 0; i < 1500; i++) {
            int cell = random_index(&random, m.graph.cell_count);
            Vec3 p = near_sides(&m.graph, cell, &random);
            cell = vis_locate(&m.graph, p, cell);
            if (cell >= 0) check_eye_cells(&m.graph, cell, p, &tally);
        }
        arena_free(&m.arena);
    }
    cr_assert(tally.alone > 2000 && tally.joined > 500 && tally.at_wall > 2000,
              "%d alone, %d joined, %d at walls", tally.alone, tally.joined, tally.at_wall);
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

// An eye on a portal, to a rasteriser's precision, sees what the cell beyond may see, even where its own may not.
Test(query_oracle, an_eye_on_a_portal_is_in_both_cells) {
    Made m = {0};
    Arena arena = {0};
    Random random = {5};
    int tried = 0;
    make(&m, pillars(&arena, &random, 8, 0.3), 5000);
    size_t words = (size_t)m.forest.words;
    uint64_t *row = ARENA_ARRAY(&arena, uint64_t, words);
    for (int p = 0; p < m.graph.portal_count; p++) {
        const Portal *portal = &m.graph.portals[p];
        Vec3 eye = vec3_add(in_portal(&m.graph, portal, &random), vec3_scale(portal->plane.n, 1e-9));
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
        cr_assert(lists(&after, far), "portal %d: cell %d, which %d may see, is not found from %d", p, far,
                  there, here);
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
        make(&m, pillars(&m.arena, &random, 7, 0.1 + 0.03 * (double)(seed % 6)), seed % 2 ? 3 : 100000);
        check_eyes(&m, 150, false, &random, &tally);
        arena_free(&m.arena);
    }
    cr_assert(tally.lines > 20000 && tally.cells > 2 * tally.lines, "%ld lines, %ld cells", tally.lines,
              tally.cells);
    cr_assert(tally.outside < tally.eyes / 2, "%ld of %ld eyes are at a wall", tally.outside, tally.eyes);
}

// Proves it of rooms with doorways and pillars, on two storeys.
Test(query_oracle, rooms) {
    Tally tally = {0};
    for (uint64_t seed = 1; seed <= 8; seed++) {
        Made m = {0};
        Random random = {seed};
        make(&m, fixture_rooms(&m.arena, &random, 3, 3, 1 + (int)(seed % 2)), seed % 2 ? 3 : 5000);
        check_eyes(&m, 150, false, &random, &tally);
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
        make(&m, b, seed % 2 ? 3 : 5000);
        m.doors = ARENA_ARRAY(&m.arena, float, b->opening_count);
        for (int i = 0; i < b->opening_count; i++) m.doors[i] = random_index(&random, 3) ? 0 : 0.5f;
        check_eyes(&m, 100, false, &random, &tally);
        for (int c = 0; c < m.graph.cell_count; c++)
            check_eye(&m, c, soup_fixture_point(&m.graph, &random, c), CULL_PORTALS, false, &random, &tally);
        arena_free(&m.arena);
    }
    cr_assert(tally.lines > 10000 && tally.shut > 1000, "%ld lines, %ld pairs", tally.lines, tally.shut);
}

// Proves that an eye where four cells meet, with no wall near, is in one of them and sees all four.
Test(query_oracle, where_four_cells_meet) {
    Made m = {0};
    Random random = {1};
    make(&m, pillars(&m.arena, &random, 4, 0), 5000);
    for (int i = 0; i < 9; i++) {
        Eye eye = {.position = vec3(4 + 1e-9 * (i % 3 - 1), 4 + 1e-9 * (i / 3 - 1), 1.6)};
        int cell = vis_locate(&m.graph, eye.position, -1);
        VisResult result = vis_query(m.query, &eye, cell, NULL, CULL_STAB);
        cr_assert_eq(result.eye_cell, cell);
        for (int k = 0; k < 4; k++) {
            Vec3 p = vec3(4 + (k % 2 ? 1 : -1), 4 + (k / 2 ? 1 : -1), 1.6);
            cr_assert(lists(&result, vis_locate(&m.graph, p, -1)), "eye %d, corner %d", i, k);
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
        make(&m, b, 200);
        const CellGraph *g = &m.graph;
        for (int i = 0; i < 150; i++) {
            int cell = random_index(&random, g->cell_count);
            Vec3 p = i % 3 || g->cells[cell].way_count == 0 ? soup_fixture_point(g, &random, cell)
                                                            : at_portal(g, cell, &random);
            cell = vis_locate(g, p, cell);
            if (cell >= 0) check_eye(&m, cell, p, CULL_PORTALS, false, &random, &tally);
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
        make(&m, b, 5000);
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
            if (result.eye_cell < 0) continue;
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
        make(&m, &b, 100);
        const CellGraph *g = &m.graph;
        for (int i = 0; i < support_count(150, 2000); i++) {
            int cell = random_index(&random, g->cell_count);
            if (g->cells[cell].way_count == 0) continue;
            check_eye(&m, cell, at_portal(g, cell, &random), CULL_PORTALS, true, &random, &tally);
        }
        cr_assert(tally.lines > 1000 && tally.outside == 0, "%ld lines, %ld eyes outside", tally.lines,
                  tally.outside);
        arena_free(&m.arena);
    }
}
