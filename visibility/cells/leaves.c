// leaves.c - doors in motion: where their leaves stand, and the space that they sweep.
#include "visibility/cells/build.h"

void vis_pose(const CellGraph *graph, const float *door_open, Vec3 *vertices) {
    const Building *b = graph->building;
    for (int i = 0; i < b->object_count; i++) {
        const Object *object = &graph->objects[i];
        if (object->leaf < 0) continue;
        const Leaf *leaf = &b->leaves[object->leaf];
        double open = door_open ? (double)door_open[leaf->opening] : 1;
        const Polygon *first = &graph->polygons[object->first_polygon], *end = first + object->polygon_count;
        for (const Polygon *p = first; p < end; p++) {
            for (int k = p->first_vertex; k < p->first_vertex + p->vertex_count; k++)
                vertices[k] = leaf_point(leaf, open, graph->vertices[k]);
        }
    }
}

Vec3 *vis_posed(const CellGraph *graph, const float *door_open, Arena *arena) {
    Vec3 *vertices = ARENA_ARRAY(arena, Vec3, graph->vertex_count + 1);
    if (graph->vertex_count > 0)
        memcpy(vertices, graph->vertices, (size_t)graph->vertex_count * sizeof *vertices);
    vis_pose(graph, door_open, vertices);
    return vertices;
}

// The leaf's plan box among its own polygons, in a frame along its axis, as when closed.
static Box own_box(const CellGraph *graph, const Object *object, const Leaf *leaf, Vec2 along) {
    Box box = box_empty();
    const Polygon *first = &graph->polygons[object->first_polygon], *end = first + object->polygon_count;
    for (const Polygon *p = first; p < end; p++) {
        for (int k = p->first_vertex; k < p->first_vertex + p->vertex_count; k++) {
            Vec3 v = graph->vertices[k];
            Vec2 from = vec2(v.x - leaf->pivot.x, v.y - leaf->pivot.y);
            box = box_add(box, vec3(vec2_dot(along, from), vec2_cross(along, from), v.z));
        }
    }
    return box;
}

void build_swept(const CellGraph *graph, int object, SweptLeaf *out) {
    const Object *o = &graph->objects[object];
    const Leaf *leaf = &graph->building->leaves[o->leaf];
    Vec2 along = vec2_sub(leaf->axis[1], leaf->axis[0]);
    along = vec2_scale(along, 1 / vec2_length(along));
    Box box = own_box(graph, o, leaf, along);
    double reach = hypot(fmax(-box.min.x, box.max.x), fmax(-box.min.y, box.max.y));
    // No point of the leaf is ever farther than this from where it is at the nearest of the steps.
    double grow = (reach * fabs(leaf->turn) + vec2_length(leaf->slide)) / (2 * (SWEPT_STEPS - 1));
    double x[4] = {box.min.x - grow, box.max.x + grow, box.max.x + grow, box.min.x - grow};
    double y[4] = {box.min.y - grow, box.min.y - grow, box.max.y + grow, box.max.y + grow};
    out->z0 = box.min.z + fmin(leaf->rise, 0);
    out->z1 = box.max.z + fmax(leaf->rise, 0);
    for (int i = 0; i < SWEPT_STEPS; i++) {
        for (int k = 0; k < 4; k++) {
            Vec3 closed = vec3(leaf->pivot.x + along.x * x[k] - along.y * y[k],
                               leaf->pivot.y + along.y * x[k] + along.x * y[k], 0);
            out->plan[i][k] = leaf_point(leaf, (double)i / (SWEPT_STEPS - 1), closed);
        }
    }
}
