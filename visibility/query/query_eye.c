// query_eye.c - the cells in which the view of an eye begins: those it is in, to a rasteriser's precision, and of an eye in no cell
// those close by.
#include "visibility/query/query.h"

// An eye this near a wall may be behind it in the floats of a rasteriser, or see through it where its near plane cuts
// it off, metres. A view whose near plane is farther than this must keep its eye that much off the walls.
static const double EYE_CLEARANCE = 1e-3;
// An eye in no cell, but this near one, is in a wall or in a piece that stands there, metres: more than the half of most walls, so that
// one that flies through a wall is never without both its sides, and more than the smoothed path of a tour cuts off a corner.
static const double EYE_REACH = 0.25;

// How far the point is outside the planes of a cell, metres: never more than it is from the cell; negative inside.
static double outside_cell(const CellGraph *graph, const Cell *cell, Vec3 p) {
    double off = -INFINITY;
    for (int i = cell->first_face; i < cell->first_face + cell->face_count; i++)
        off = fmax(off, -plane_distance(graph->faces[i], p));
    if (cell->face_count > 0) return off;
    off = fmax(cell->z0 - p.z, p.z - cell->z1);
    const Vec2 *plan = graph->plan + cell->first_edge;
    for (int i = 0; i < cell->edge_count; i++) {
        Vec2 a = plan[i], edge = vec2_sub(plan[i + 1 == cell->edge_count ? 0 : i + 1], a);
        double length = vec2_length(edge);
        if (length > 0) off = fmax(off, -vec2_cross(edge, vec2_sub(vec2(p.x, p.y), a)) / length);
    }
    return off;
}

static int locator_place(double x, int count) { return x < 0 ? 0 : x >= count ? count - 1 : (int)x; }

static bool is_among(const int *cells, int count, int cell) {
    for (int i = 0; i < count; i++) {
        if (cells[i] == cell) return true;
    }
    return false;
}

// Adds to the first `count` cells all that the point is nearer to than `distance`, whatever lies between. Returns how many there are
// then, or 0 where there are too many.
static int cells_within(const CellGraph *graph, Vec3 p, double distance, int count, int cells[MOST_AROUND]) {
    const SquareGrid *grid = &graph->locator;
    Box near = box_grow((Box){p, p}, distance);
    int x0 = locator_place((near.min.x - grid->origin.x) / grid->size, grid->nx),
        x1 = locator_place((near.max.x - grid->origin.x) / grid->size, grid->nx),
        y0 = locator_place((near.min.y - grid->origin.y) / grid->size, grid->ny),
        y1 = locator_place((near.max.y - grid->origin.y) / grid->size, grid->ny);
    for (int y = y0; y <= y1; y++) {
        int end = graph->locator_first[y * grid->nx + x1 + 1];
        for (int k = graph->locator_first[y * grid->nx + x0]; k < end; k++) {
            int c = graph->locator_cells[k];
            const Cell *cell = &graph->cells[c];
            if (!box_overlap(cell->box, near) || is_among(cells, count, c) ||
                outside_cell(graph, cell, p) >= distance)
                continue;
            if (count == MOST_AROUND) return 0;
            cells[count++] = c;
        }
    }
    return count;
}

static bool at_portal(const CellGraph *graph, const Portal *portal, Vec3 eye) {
    if (fabs(plane_distance(portal->plane, eye)) >= POSITION_SLACK) return false;
    Box box = box_empty();
    for (int i = 0; i < portal->vertex_count; i++)
        box = box_add(box, graph->portal_vertices[portal->first_vertex + i]);
    return box_contains(box_grow(box, POSITION_SLACK), eye);
}

// The cells that the eye is in through portals, to POSITION_SLACK, its own first. Returns how many, or 0 where there are too many.
static int cells_at_portals(const CellGraph *graph, int cell, Vec3 eye, int cells[MOST_AROUND]) {
    int count = 0;
    cells[count++] = cell;
    for (int i = 0; i < count; i++) {
        const Cell *c = &graph->cells[cells[i]];
        for (int k = c->first_way; k < c->first_way + c->way_count; k++) {
            Way way = graph->ways[k];
            if (is_among(cells, count, way.cell) || !at_portal(graph, &graph->portals[way.portal], eye))
                continue;
            if (count == MOST_AROUND) return 0;
            cells[count++] = way.cell;
        }
    }
    return count;
}

int query_eye_cells(const CellGraph *graph, int cell, const Eye *eye, int cells[MOST_AROUND]) {
    Vec3 p = eye->position;
    // The walls of given cells are not known, nor therefore where these cells end.
    bool given = graph->building->form == FORM_CELLS;
    if (cell < 0) {
        bool close = !given && !eye->on_surface && box_contains(graph->box, p);
        return close ? cells_within(graph, p, EYE_REACH, 0, cells) : 0;
    }
    cells[0] = cell;
    if (outside_cell(graph, &graph->cells[cell], p) <= -EYE_CLEARANCE) return 1;
    return given || eye->on_surface ? cells_at_portals(graph, cell, p, cells)
                                    : cells_within(graph, p, EYE_CLEARANCE, 1, cells);
}
