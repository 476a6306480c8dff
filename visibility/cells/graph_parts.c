// graph_parts.c - parts that all kinds of cell graphs share: the polygon of a cell, the ends of a portal, the portals of each cell.
#include "visibility/cells/build.h"

static const double UPRIGHT = 1e-9;  // a portal's normal may rise so much (sine) and still count as level

int cell_polygon(const CellGraph *graph, const Cell *cell, double z, Vec3 *out) {
    for (int i = 0; i < cell->edge_count; i++) {
        Vec2 p = graph->plan[cell->first_edge + i];
        out[i] = vec3(p.x, p.y, z);
    }
    return cell->edge_count;
}

void portal_set_ends(Portal *portal, const Vec3 *v) {
    portal->horizontal = fabs(portal->plane.n.z) > UPRIGHT;
    // Seen when crossing from cell[0], along -n, `left` is the end farthest to the left.
    Vec2 to_left = {portal->plane.n.y, -portal->plane.n.x};
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < portal->vertex_count; i++) {
        Vec2 p = {v[i].x, v[i].y};
        double at = vec2_dot(p, to_left);
        if (at < low) low = at, portal->right = p;
        if (at > high) high = at, portal->left = p;
    }
}

void list_ways(CellBuilder *builder) {
    CellGraph *graph = builder->graph;
    for (int p = 0; p < graph->portal_count; p++) {
        for (int side = 0; side < 2; side++) graph->cells[graph->portals[p].cell[side]].way_count++;
    }
    for (int c = 0; c < graph->cell_count; c++) {
        graph->cells[c].first_way = graph->way_count;
        graph->way_count += graph->cells[c].way_count;
        graph->cells[c].way_count = 0;
    }
    graph->ways = ARENA_ARRAY(builder->arena, Way, graph->way_count);
    for (int p = 0; p < graph->portal_count; p++) {
        for (int side = 0; side < 2; side++) {
            Cell *cell = &graph->cells[graph->portals[p].cell[side]];
            graph->ways[cell->first_way + cell->way_count++] = (Way){p, graph->portals[p].cell[1 - side]};
        }
    }
}
