// soup_objects.c - the drawn polygons of a soup: its own, and a plug in each portal that a door closes.
#include "engine/core/error.h"
#include "visibility/soup/soup.h"

static void add_plug(CellBuilder *builder, const Portal *portal) {
    CellGraph *graph = builder->graph;
    const Opening *opening = &builder->building->openings[portal->door];
    Object *object =
        ARENA_PUSH(builder->arena, graph->objects, graph->object_count, builder->object_capacity);
    *object = (Object){.kind = OBJECT_LEAF,
                       .name = opening->name,
                       .first_polygon = graph->polygon_count,
                       .polygon_count = 1,
                       .opening = portal->door,
                       .leaf = -1,
                       .plug = true};
    *ARENA_PUSH(builder->arena, graph->polygons, graph->polygon_count, builder->polygon_capacity) =
        (Polygon){graph->vertex_count, portal->vertex_count, opening->material, 0};
    for (int i = 0; i < portal->vertex_count; i++)
        *ARENA_PUSH(builder->arena, graph->vertices, graph->vertex_count, builder->vertex_capacity) =
            graph->portal_vertices[portal->first_vertex + i];
}

void soup_write_objects(const Soup *soup) {
    CellBuilder *builder = soup->builder;
    CellGraph *graph = builder->graph;
    const Building *b = builder->building;
    for (int i = 0; i < b->object_count; i++)
        *ARENA_PUSH(builder->arena, graph->objects, graph->object_count, builder->object_capacity) =
            b->objects[i];
    for (int i = 0; i < b->polygon_count; i++)
        *ARENA_PUSH(builder->arena, graph->polygons, graph->polygon_count, builder->polygon_capacity) =
            b->polygons[i];
    for (int i = 0; i < b->vertex_count; i++)
        *ARENA_PUSH(builder->arena, graph->vertices, graph->vertex_count, builder->vertex_capacity) =
            b->vertices[i];
    graph->surface_first = ARENA_ARRAY(builder->arena, int, graph->cell_count + 1);
    for (int c = 0; c <= graph->cell_count; c++) graph->surface_first[c] = graph->object_count;
    for (int p = 0; p < graph->portal_count; p++) {
        if (graph->portals[p].door >= 0) add_plug(builder, &graph->portals[p]);
    }
}
