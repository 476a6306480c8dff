// given.c - cells and portals as a building gives them. A cell's faces are its portals' planes and the box of their
// corners: its other walls are not known, so it may be larger than the room the walls leave.
#include "engine/core/polygon.h"
#include "visibility/cells/build.h"

static void add_portal(CellBuilder *builder, const GivenPortal *given, Portal *out) {
    CellGraph *graph = builder->graph;
    const Vec3 *v = builder->building->vertices + given->first_vertex;
    *out = (Portal){.cell = {given->cell[0], given->cell[1]},
                    .first_vertex = given->first_vertex,
                    .vertex_count = given->vertex_count,
                    .plane = plane_of_polygon(v, given->vertex_count),
                    .door = -1};
    portal_set_ends(out, v);
    for (int side = 0; side < 2; side++) {
        Cell *cell = &graph->cells[given->cell[side]];
        for (int i = 0; i < given->vertex_count; i++) cell->box = box_add(cell->box, v[i]);
    }
}

// The faces of a cell, and its box as its plan.
static void bound_cell(CellBuilder *builder, int c, int *face_capacity) {
    CellGraph *graph = builder->graph;
    Cell *cell = &graph->cells[c];
    if (box_is_empty(cell->box)) cell->box = (Box){{0, 0, 0}, {0, 0, 0}};  // no portal: nobody sees it
    cell->z0 = cell->box.min.z;
    cell->z1 = cell->box.max.z;
    cell->first_face = graph->face_count;
    for (int i = cell->first_way; i < cell->first_way + cell->way_count; i++) {
        const Portal *portal = &graph->portals[graph->ways[i].portal];
        Plane inward = portal->plane;
        if (portal->cell[0] != c) inward = (Plane){vec3_scale(inward.n, -1), -inward.d};
        *ARENA_PUSH(builder->arena, graph->faces, graph->face_count, *face_capacity) = inward;
    }
    cell->face_count = graph->face_count - cell->first_face;
    cell->first_edge = graph->plan_count;
    cell->edge_count = 4;
    Vec3 low = cell->box.min, high = cell->box.max;
    Vec2 corner[4] = {{low.x, low.y}, {high.x, low.y}, {high.x, high.y}, {low.x, high.y}};
    for (int i = 0; i < 4; i++)
        *ARENA_PUSH(builder->arena, graph->plan, graph->plan_count, builder->plan_capacity) = corner[i];
    graph->box = box_union(graph->box, cell->box);
}

bool build_given(CellBuilder *builder, Error *error) {
    const Building *b = builder->building;
    CellGraph *graph = builder->graph;
    (void)error;
    graph->cell_count = b->given_cell_count;
    graph->cells = ARENA_ARRAY(builder->arena, Cell, graph->cell_count);
    graph->portal_vertices = b->vertices;
    graph->portal_vertex_count = b->vertex_count;
    graph->portal_count = b->given_portal_count;
    graph->portals = ARENA_ARRAY(builder->arena, Portal, graph->portal_count);
    graph->box = box_empty();
    for (int c = 0; c < graph->cell_count; c++) {
        graph->cells[c].region = -1;
        graph->cells[c].box = box_empty();
    }
    for (int p = 0; p < graph->portal_count; p++)
        add_portal(builder, &b->given_portals[p], &graph->portals[p]);
    list_ways(builder);
    int face_capacity = 0;
    for (int c = 0; c < graph->cell_count; c++) bound_cell(builder, c, &face_capacity);
    graph->surface_first = ARENA_ARRAY(builder->arena, int, graph->cell_count + 1);
    return true;
}
