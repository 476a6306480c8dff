// query_eye.c - the cells that an eye is in, to a rasteriser's precision, and whether it is too near a wall to tell.
#include "engine/core/polygon.h"
#include "visibility/query/query.h"

// An eye this near a wall may be behind it in the floats of a rasteriser, or see through it where its near plane cuts
// it off, metres. A view whose near plane is farther than this must keep its eye that much off the walls.
static const double EYE_CLEARANCE = 1e-3;

// Is the point nearer than EYE_CLEARANCE to a convex polygon?
static bool near_polygon(const CellGraph *graph, const Polygon *polygon, Vec3 eye) {
    const Vec3 *v = graph->vertices + polygon->first_vertex;
    Box box = box_empty();
    for (int i = 0; i < polygon->vertex_count; i++) box = box_add(box, v[i]);
    if (!box_contains(box_grow(box, EYE_CLEARANCE), eye)) return false;
    Plane plane = plane_of_polygon(v, polygon->vertex_count);
    if (fabs(plane_distance(plane, eye)) >= EYE_CLEARANCE) return false;
    for (int i = 0; i < polygon->vertex_count; i++) {
        Vec3 edge = vec3_normalize(vec3_sub(v[(i + 1) % polygon->vertex_count], v[i]));
        if (vec3_dot(vec3_cross(plane.n, edge), vec3_sub(eye, v[i])) <= -EYE_CLEARANCE) return false;
    }
    return true;
}

static bool near_object(const CellGraph *graph, int object, Vec3 eye) {
    if (!box_contains(box_grow(graph->object_boxes[object], EYE_CLEARANCE), eye)) return false;
    const Object *o = &graph->objects[object];
    for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++) {
        if (near_polygon(graph, &graph->polygons[p], eye)) return true;
    }
    return false;
}

// The walls of a cell are its surfaces; those of a soup's are anything that touches it.
static bool near_wall(const CellGraph *graph, int c, Vec3 eye) {
    for (int i = graph->surface_first[c]; i < graph->surface_first[c + 1]; i++) {
        if (near_object(graph, i, eye)) return true;
    }
    if (graph->cells[c].face_count == 0) return false;
    const SquareGrid *grid = &graph->grids[c];
    int end = graph->square_first[grid->first_square + grid->nx * grid->ny];
    for (int k = graph->square_first[grid->first_square]; k < end; k++) {
        if (near_object(graph, graph->square_objects[k], eye)) return true;
    }
    return false;
}

static bool near_boundary(const CellGraph *graph, const Cell *cell, Vec3 eye) {
    for (int i = cell->first_face; i < cell->first_face + cell->face_count; i++) {
        if (plane_distance(graph->faces[i], eye) < EYE_CLEARANCE) return true;
    }
    if (cell->face_count > 0) return false;
    if (eye.z - cell->z0 < EYE_CLEARANCE || cell->z1 - eye.z < EYE_CLEARANCE) return true;
    const Vec2 *plan = graph->plan + cell->first_edge;
    for (int i = 0; i < cell->edge_count; i++) {
        Vec2 a = plan[i], edge = vec2_sub(plan[i + 1 == cell->edge_count ? 0 : i + 1], a);
        double off = vec2_cross(edge, vec2_sub(vec2(eye.x, eye.y), a));
        if (off < EYE_CLEARANCE * vec2_length(edge)) return true;
    }
    return false;
}

static bool near_portal(const CellGraph *graph, const Portal *portal, Vec3 eye, double distance) {
    if (fabs(plane_distance(portal->plane, eye)) >= distance) return false;
    Box box = box_empty();
    for (int i = 0; i < portal->vertex_count; i++)
        box = box_add(box, graph->portal_vertices[portal->first_vertex + i]);
    return box_contains(box_grow(box, distance), eye);
}

// The cells that the eye is nearer to than `distance`, through portals, its own first. Returns how many, or 0 where there
// are too many.
static int cells_around(const CellGraph *graph, int cell, Vec3 eye, double distance, int cells[MOST_AROUND]) {
    int count = 0;
    cells[count++] = cell;
    for (int i = 0; i < count; i++) {
        const Cell *c = &graph->cells[cells[i]];
        for (int k = c->first_way; k < c->first_way + c->way_count; k++) {
            Way way = graph->ways[k];
            int known = 0;
            while (known < count && cells[known] != way.cell) known++;
            if (known < count || !near_portal(graph, &graph->portals[way.portal], eye, distance)) continue;
            if (count == MOST_AROUND) return 0;
            cells[count++] = way.cell;
        }
    }
    return count;
}

// Is the eye farther than EYE_CLEARANCE from the walls of all these cells? Of given cells no walls are known.
static bool clear_of_walls(const CellGraph *graph, const int *cells, int count, Vec3 eye) {
    if (graph->building->form == FORM_CELLS) return true;
    for (int i = 0; i < count; i++) {
        if (near_wall(graph, cells[i], eye)) return false;
    }
    return count > 0;
}

int query_eye_cells(const CellGraph *graph, int cell, const Eye *eye, int cells[MOST_AROUND]) {
    cells[0] = cell;
    if (!near_boundary(graph, &graph->cells[cell], eye->position)) return 1;
    int count = cells_around(graph, cell, eye->position, EYE_CLEARANCE, cells);
    if (!eye->on_surface && !clear_of_walls(graph, cells, count, eye->position)) return 0;
    return count > 1 ? cells_around(graph, cell, eye->position, POSITION_SLACK, cells) : count;
}
