// witness.c - a sightline walked again, cell by cell.
//
// A line pierces a convex polygon iff it passes all edges on the same side, and how near it comes to an edge is the
// distance between two lines (J. Pluecker, 1865): no point of intersection is computed, only differences of given points
// enter, so a far origin does not blur the sign. What rounding may have added where an edge and the line run nearly along
// each other is taken off the distance.
#include "visibility/pairs/witness.h"

// A start may lie so far outside its cell, in shares of the building's size, beyond what the cell's own corners do.
static const double START_SLACK = 1e-9;
// Crossings follow each other along the line; portals back to back may change places by rounding. Shares of the segment.
static const double ORDER_SLACK = 1e-9;

// The distance of two lines at a right angle is computed to this share of the building's size, and to more by the sine
// of their angle: a few times the rounding of one operation.
static const double ROUNDING = 1e-15;

typedef struct Line {
    Vec3 from, along;
    double length;
    double size;  // of the building, metres
} Line;

typedef struct Crossing {
    double at;      // share of the segment
    double spread;  // of `at`: a bent portal is crossed somewhere around its plane
    double margin;  // metres; negative: the line misses the portal
    double sine;    // of the angle to the portal, positive from cell[0] to cell[1]
} Crossing;

static Crossing cross(const CellGraph *graph, const Portal *portal, const Line *line) {
    const Vec3 *v = graph->portal_vertices + portal->first_vertex;
    double fall = -vec3_dot(portal->plane.n, line->along), side = fall > 0 ? 1 : -1;
    Crossing c = {.margin = INFINITY, .sine = fall / line->length};
    double bend = 0;
    c.at = vec3_dot(portal->plane.n, vec3_sub(line->from, v[0])) / fall;
    for (int i = 0; i < portal->vertex_count; i++) {
        Vec3 a = v[i], edge = vec3_sub(v[i + 1 == portal->vertex_count ? 0 : i + 1], a);
        Vec3 across = vec3_cross(edge, line->along);
        double width = vec3_length(across);
        double doubt = ROUNDING * line->size * line->length * vec3_length(edge) / width;
        double distance = side * vec3_dot(across, vec3_sub(line->from, a)) / width - doubt;
        // An edge without length, or one along the line, says nothing: its neighbours or the angle do.
        if (distance < c.margin) c.margin = distance;
        bend = fmax(bend, fabs(vec3_dot(portal->plane.n, vec3_sub(a, v[0]))));
    }
    c.spread = bend / fabs(fall);
    return c;
}

static double extent(const CellGraph *graph) {
    Vec3 size = vec3_sub(graph->box.max, graph->box.min);
    // A double resolves 1e-10 m at 1e6 m: a tenth of the margin there.
    static const double DIGITS = 1e-5;
    return fmax(vec3_length(size), DIGITS * fmax(vec3_length(graph->box.max), vec3_length(graph->box.min)));
}

// How far `p` lies outside the faces of a polyhedron, and how far its own portals' corners do: files round.
static bool within_faces(const CellGraph *graph, const Cell *cell, Vec3 p, double slack) {
    for (int f = cell->first_face; f < cell->first_face + cell->face_count; f++) {
        double lowest = 0, distance = plane_distance(graph->faces[f], p);
        if (distance >= -slack) continue;
        for (int i = cell->first_way; i < cell->first_way + cell->way_count; i++) {
            const Portal *portal = &graph->portals[graph->ways[i].portal];
            for (int k = portal->first_vertex; k < portal->first_vertex + portal->vertex_count; k++)
                lowest = fmin(lowest, plane_distance(graph->faces[f], graph->portal_vertices[k]));
        }
        if (distance < lowest - slack) return false;
    }
    return true;
}

static bool within_prism(const CellGraph *graph, const Cell *cell, Vec3 p, double slack) {
    if (p.z < cell->z0 - slack || p.z > cell->z1 + slack) return false;
    for (int i = 0; i < cell->edge_count; i++) {
        Vec2 a = graph->plan[cell->first_edge + i];
        Vec2 edge = vec2_sub(graph->plan[cell->first_edge + (i + 1) % cell->edge_count], a);
        if (vec2_cross(edge, vec2_sub(vec2(p.x, p.y), a)) < -slack * vec2_length(edge)) return false;
    }
    return true;
}

// The way through which the line leaves the cell, nearest first, or -1.
static int exit_of(const CellGraph *graph, int c, const Line *line, double since, double margin,
                   Crossing *out) {
    const Cell *cell = &graph->cells[c];
    int found = -1;
    for (int i = cell->first_way; i < cell->first_way + cell->way_count; i++) {
        const Portal *portal = &graph->portals[graph->ways[i].portal];
        Crossing crossing = cross(graph, portal, line);
        double outward = portal->cell[0] == c ? crossing.sine : -crossing.sine;
        if (!(outward > WITNESS_FLATTEST) || !(crossing.margin > margin)) continue;
        double slack = ORDER_SLACK + crossing.spread;
        if (crossing.at < since - slack || crossing.at > 1 + slack) continue;
        if (found >= 0 && crossing.at >= out->at) continue;
        found = i;
        *out = crossing;
    }
    return found;
}

WitnessWalk witness_walk(const CellGraph *graph, int a, int b, Vec3 from, Vec3 to) {
    WitnessWalk walk = {.margin = INFINITY, .flattest = 1};
    double size = extent(graph), slack = START_SLACK * size, since = 0;
    Vec3 along = vec3_sub(to, from);
    Line line = {from, along, vec3_length(along), size};
    const Cell *start = &graph->cells[a];
    bool inside =
        start->face_count ? within_faces(graph, start, from, slack) : within_prism(graph, start, from, slack);
    if (!inside) return walk;
    int cell = a;
    // A straight line is in each convex cell once.
    while (cell != b && walk.crossed < graph->cell_count) {
        Crossing crossing = {0};
        int way = exit_of(graph, cell, &line, since, WITNESS_MARGIN * size, &crossing);
        if (way < 0) return walk;
        walk.crossed++;
        walk.margin = fmin(walk.margin, crossing.margin);
        walk.flattest = fmin(walk.flattest, fabs(crossing.sine));
        since = crossing.at;
        cell = graph->ways[way].cell;
    }
    walk.proves = cell == b;
    return walk;
}
