// query_fixture.c - see the header.
#include "tests/visibility/query/query_fixture.h"

#include <criterion/criterion.h>

#include "tests/support/fixture.h"
#include "tests/support/soup_fixture.h"
#include "tests/support/support.h"
#include "visibility/query/query.h"

void query_check_make(Made *m, const Building *b, int max_nodes) {
    VisOptions options = vis_default_options();
    options.max_nodes = max_nodes;
    Error error = {""};
    m->building = b;
    cr_assert(vis_build_cells(b, &options, &m->arena, &m->graph, &error), "%s", error.text);
    cr_assert(vis_build_forest(&m->graph, &options, NULL, &m->arena, &m->forest));
    m->query = vis_query_new(&m->graph, &m->forest, &m->arena);
}

Building *query_check_pillars(Arena *arena, Random *random, int n, double solid) {
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

int query_check_cell_planes(const CellGraph *g, int c, Plane *out) {
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

// The stretch of the line after `after` that lies in the cell; false where there is none worth the name.
static bool stretch_in(const CellGraph *g, int c, const Line *line, double after, double *in, double *out) {
    Plane planes[256];
    *in = after, *out = INFINITY;
    int count = query_check_cell_planes(g, c, planes);
    for (int i = 0; i < count; i++) {
        double off = plane_distance(planes[i], line->from), rate = vec3_dot(planes[i].n, line->way);
        if (rate > 0) *in = fmax(*in, -off / rate);
        if (rate < 0) *out = fmin(*out, -off / rate);
        if (rate == 0 && off < 0) return false;
    }
    return *out > *in + 10 * DOUBTFUL;
}

// Where the line leaves the cell that it is in after `after`, else -1.
static double leaves_at(const CellGraph *g, int c, const Line *line, double after) {
    double in, out;
    return stretch_in(g, c, line, after, &in, &out) && in < after + DOUBTFUL ? out : -1;
}

static bool is_closed(const Portal *portal, const float *doors) {
    return portal->door >= 0 && doors && doors[portal->door] == 0;
}

// Follows the line through cells as they are bounded, on from where it enters a cell. False: given up.
static bool follow_from(const CellGraph *g, int cell, double at, Line *line) {
    line->count = 0;
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

// From whichever cell holds its beginning.
static bool follow(const CellGraph *g, Line *line) {
    int cell = -1;
    for (int c = 0; c < g->cell_count && cell < 0; c++) {
        if (box_contains(box_grow(g->cells[c].box, 1e-5), line->from) && leaves_at(g, c, line, 0) > 0)
            cell = c;
    }
    return follow_from(g, cell, 0, line);
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

bool query_check_lists(const VisResult *result, int cell) {
    for (int i = 0; i < result->cell_count; i++) {
        if (result->cells[i].cell == cell) return true;
    }
    return false;
}

Vec3 query_check_in_portal(const CellGraph *g, const Portal *portal, Random *random) {
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

Vec3 query_check_at_portal(const CellGraph *g, int cell, Random *random) {
    const Cell *c = &g->cells[cell];
    const Portal *portal = &g->portals[g->ways[c->first_way + random_index(random, c->way_count)].portal];
    Vec3 p = query_check_in_portal(g, portal, random);
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

double query_check_outside(const CellGraph *g, int c, Vec3 p) {
    Plane planes[256];
    int count = query_check_cell_planes(g, c, planes);
    double off = -INFINITY;
    for (int i = 0; i < count; i++) off = fmax(off, -plane_distance(planes[i], p));
    return off;
}

// The view of an eye in free space may begin in any cell that it is this near to, metres.
static const double CLEARANCE = 1e-3;

// Is the cell in the visible set of the eye's cell, or of another in which its view may begin?
static bool may_see(const Made *m, int eye_cell, Vec3 eye, int cell) {
    if (vis_sees(&m->forest, eye_cell, cell)) return true;
    for (int c = 0; c < m->graph.cell_count; c++) {
        if (vis_sees(&m->forest, c, cell) && box_contains(box_grow(m->graph.cells[c].box, CLEARANCE), eye))
            return true;
    }
    return false;
}

// Cells that a way without closed doors leads to from those in which the view may begin.
static unsigned char *reachable(const Made *m, Vec3 eye, Arena *arena) {
    const CellGraph *g = &m->graph;
    unsigned char *reached = ARENA_ARRAY(arena, unsigned char, g->cell_count);
    for (int c = 0; c < g->cell_count; c++)
        reached[c] = box_contains(box_grow(g->cells[c].box, CLEARANCE), eye);
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

static void expect_listed(const CellGraph *g, const VisResult *result, Culling culling, const Line *line,
                          int cell) {
    for (int i = 0; i < line->count; i++)
        cr_assert(
            query_check_lists(result, line->cells[i]),
            "%s: eye (%.12g, %.12g, %.12g) in cell %d (%d) sees cell %d (%d on its line), which is not found",
            CULLING_NAMES[culling], line->from.x, line->from.y, line->from.z, cell, g->cell_count,
            line->cells[i], i);
}

void query_check_check_eye(Made *m, int cell, Vec3 position, Culling culling, bool given, Random *random,
                           Tally *tally) {
    const CellGraph *g = &m->graph;
    Eye eye = {.position = position};
    VisResult result = vis_query(m->query, &eye, cell, m->doors, culling);
    tally->eyes++;
    tally->everything += result.cell_count == 0;
    if (result.cell_count == 0) return;
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
        expect_listed(g, &result, culling, &line, cell);
    }
}

// Where the line enters the cell after `after`, or INFINITY where it does not.
static double enters_at(const CellGraph *g, int c, const Line *line, double after) {
    double in, out;
    return stretch_in(g, c, line, after, &in, &out) ? in : INFINITY;
}

void query_check_look_from(Made *m, int cell, Vec3 position, Culling culling, Random *random, Tally *tally) {
    enum { LINES = 40 };
    const CellGraph *g = &m->graph;
    // In no cell, the cells a quarter of a metre away; else those at a millimetre, but for rounding.
    double near = cell < 0 ? 0.2499 : 0.999e-3;
    VisResult result = vis_query(m->query, &(Eye){.position = position}, cell, m->doors, culling);
    tally->eyes++;
    tally->everything += result.cell_count == 0;
    if (result.cell_count == 0) return;
    for (int c = 0; c < g->cell_count; c++) {
        if (query_check_outside(g, c, position) >= near ||
            !box_contains(box_grow(g->cells[c].box, near), position))
            continue;
        tally->begun += c != cell;
        for (int k = 0; k < LINES; k++) {
            Line line = {.from = position, .way = fixture_direction(random), .doors = m->doors};
            line.way.z *= 0.2;
            double at = enters_at(g, c, &line, 0);
            if (!isfinite(at) || !follow_from(g, c, at, &line)) continue;
            tally->lines++;
            tally->cells += line.count;
            expect_listed(g, &result, culling, &line, cell);
        }
    }
}

void query_check_check_eyes(Made *m, int eyes, bool given, Random *random, Tally *tally) {
    const CellGraph *g = &m->graph;
    for (int i = 0; i < eyes; i++) {
        int cell = random_index(random, g->cell_count);
        if (g->cells[cell].way_count == 0) continue;
        Vec3 p = i % 3 == 0 && !given ? at_corner(g, cell, random) : query_check_at_portal(g, cell, random);
        if (!given) cell = vis_locate(g, p, cell);
        if (cell < 0) continue;
        query_check_check_eye(m, cell, p, i % 2 ? CULL_STAB : CULL_PORTALS, given, random, tally);
    }
}
