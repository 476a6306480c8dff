// export_mesh.c - elements as triangles, a primitive a material. A vertex is a node of light: neighbours that are smooth
// share it, so that no crack can open between them.
#include "engine/app/export_parts.h"

#include <stdlib.h>

#include "engine/core/polygon.h"

enum { FULL = 65535 };  // of a normalized unsigned short

static int look_of(const Export *e, int object, int polygon) {
    if (vis_is_glass(e->graph, polygon)) return EXPORT_GLASS;
    return e->graph->objects[object].kind == OBJECT_SURFACE ? EXPORT_WALL : EXPORT_THING;
}

bool export_shows(const Export *e, int object, int polygon) {
    return e->mesh->face_of[polygon] >= 0 ||
           (vis_is_glass(e->graph, polygon) && vis_shown(&e->graph->objects[object], e->door_open));
}

// ---- the polygons of a node, by material

typedef struct Shown {
    int polygon, key, order;
} Shown;

typedef struct ShownList {
    Shown *shown;
    int count, capacity;
    Arena arena;
} ShownList;

static int by_key(const void *a, const void *b) {
    const Shown *x = a, *y = b;
    return x->key != y->key ? (x->key < y->key ? -1 : 1) : (x->order > y->order) - (x->order < y->order);
}

static void list_shown(const Export *e, const ExportTree *tree, const ExportNode *node, ShownList *list) {
    for (int o = node->first_object; o >= 0; o = tree->next[o]) {
        const Object *object = &e->graph->objects[o];
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++) {
            if (!export_shows(e, o, p)) continue;
            int key = e->graph->polygons[p].material * EXPORT_LOOKS + look_of(e, o, p), order = list->count;
            *ARENA_PUSH(&list->arena, list->shown, list->count, list->capacity) = (Shown){p, key, order};
        }
    }
    qsort(list->shown, (size_t)list->count, sizeof *list->shown, by_key);
}

// ---- vertices

// Where a leaf stood when its light was found is undone: its node puts it there again.
static Vec3 to_node(const Export *e, const ExportNode *node, Vec3 p) {
    if (node->leaf < 0) return vec3_sub(p, e->origin);
    const Leaf *leaf = &e->graph->building->leaves[node->leaf];
    double open = e->door_open ? (double)e->door_open[leaf->opening] : 1, angle = -open * leaf->turn;
    p = vec3(p.x - leaf->pivot.x - open * leaf->slide.x, p.y - leaf->pivot.y - open * leaf->slide.y,
             p.z - open * leaf->rise);
    return vec3(cos(angle) * p.x - sin(angle) * p.y, sin(angle) * p.x + cos(angle) * p.y, p.z - e->origin.z);
}

static void add_position(Export *e, Vec3 p) {
    float *at = *ARENA_PUSH(&e->arena, e->position, e->position_count, e->position_capacity);
    at[0] = (float)p.x;
    at[1] = (float)p.y;
    at[2] = (float)p.z;
}

static void add_colour(Export *e, const double b[3]) {
    uint16_t *at = *ARENA_PUSH(&e->arena, e->colour, e->colour_count, e->colour_capacity);
    for (int c = 0; c < 3; c++) at[c] = (uint16_t)lrint(FULL * fmin(b[c] * e->exposure, 1));
    at[3] = FULL;
}

// The triangles of corners that became these vertices.
static void add_triangles(Export *e, const Vec3 *v, const int *vertex, int count) {
    Arena scratch = {0};
    int *triangle = ARENA_ARRAY(&scratch, int, 3 * count);
    polygon_triangulate(v, count, triangle);
    for (int k = 0; k < 3 * (count - 2); k++)
        *ARENA_PUSH(&e->arena, e->index, e->index_count, e->index_capacity) = (uint32_t)vertex[triangle[k]];
    arena_free(&scratch);
}

static void add_element(Export *e, const ExportNode *node, const Element *element, int first_vertex) {
    Arena scratch = {0};
    Vec3 *v = ARENA_ARRAY(&scratch, Vec3, element->corner_count);
    int *vertex = ARENA_ARRAY(&scratch, int, element->corner_count);
    for (int i = 0; i < element->corner_count; i++) {
        int corner = element->first_corner + i, at = e->nodes.of_corner[corner];
        v[i] = e->mesh->vertices[e->mesh->corners[corner]];
        if (e->stamp[at] != e->now) {
            e->stamp[at] = e->now;
            e->vertex[at] = e->position_count - first_vertex;
            add_position(e, to_node(e, node, v[i]));
            add_colour(e, e->light.corner[corner]);
        }
        vertex[i] = e->vertex[at];
    }
    add_triangles(e, v, vertex, element->corner_count);
    arena_free(&scratch);
}

static void add_face(Export *e, const ExportNode *node, int polygon, int first_vertex) {
    const Face *face = &e->mesh->faces[e->mesh->face_of[polygon]];
    for (int i = 0; i < face->element_count; i++)
        add_element(e, node, &e->mesh->elements[face->first_element + i], first_vertex);
}

// Glass has no light of its own. Of leaves it is as when closed, which is how nodes of leaves have it.
static void add_pane(Export *e, const ExportNode *node, int polygon, int first_vertex) {
    const Polygon *p = &e->graph->polygons[polygon];
    const Vec3 *v = e->graph->vertices + p->first_vertex;
    Arena scratch = {0};
    int *vertex = ARENA_ARRAY(&scratch, int, p->vertex_count);
    const double bright[3] = {1 / e->exposure, 1 / e->exposure, 1 / e->exposure};
    Vec3 from = e->origin;
    if (node->leaf >= 0) {
        const Leaf *leaf = &e->graph->building->leaves[node->leaf];
        from = vec3(leaf->pivot.x, leaf->pivot.y, e->origin.z);
    }
    for (int i = 0; i < p->vertex_count; i++) {
        vertex[i] = e->position_count - first_vertex;
        add_position(e, vec3_sub(v[i], from));
        add_colour(e, bright);
    }
    add_triangles(e, v, vertex, p->vertex_count);
    arena_free(&scratch);
}

// ---- accessors

enum { UNSIGNED_SHORT = 5123, UNSIGNED_INT = 5125, FLOAT = 5126 };

static int add_accessor(Export *e, json_t *accessor) {
    json_array_append_new(e->accessors, accessor);
    return (int)json_array_size(e->accessors) - 1;
}

static int add_positions(Export *e, int first) {
    float low[3], high[3];
    memcpy(low, e->position[first], sizeof low);
    memcpy(high, low, sizeof high);
    for (int i = first; i < e->position_count; i++) {
        for (int c = 0; c < 3; c++) {
            low[c] = fminf(low[c], e->position[i][c]);
            high[c] = fmaxf(high[c], e->position[i][c]);
        }
    }
    return add_accessor(e,
                        json_pack("{s:i s:I s:i s:i s:s s:[f f f] s:[f f f]}", "bufferView", EXPORT_POSITIONS,
                                  "byteOffset", (json_int_t)first * (json_int_t)sizeof *e->position,
                                  "componentType", FLOAT, "count", e->position_count - first, "type", "VEC3",
                                  "min", (double)low[0], (double)low[1], (double)low[2], "max",
                                  (double)high[0], (double)high[1], (double)high[2]));
}

// Polygons of one key.
static json_t *add_primitive(Export *e, const ExportNode *node, const Shown *shown, int count) {
    int vertex = e->position_count, index = e->index_count;
    e->now++;
    for (int i = 0; i < count; i++) {
        if (e->mesh->face_of[shown[i].polygon] >= 0)
            add_face(e, node, shown[i].polygon, vertex);
        else
            add_pane(e, node, shown[i].polygon, vertex);
    }
    int positions = add_positions(e, vertex);
    int colours = add_accessor(e, json_pack("{s:i s:I s:i s:b s:i s:s}", "bufferView", EXPORT_COLOURS,
                                            "byteOffset", (json_int_t)vertex * (json_int_t)sizeof *e->colour,
                                            "componentType", UNSIGNED_SHORT, "normalized", 1, "count",
                                            e->colour_count - vertex, "type", "VEC4"));
    int indices =
        add_accessor(e, json_pack("{s:i s:I s:i s:i s:s}", "bufferView", EXPORT_INDICES, "byteOffset",
                                  (json_int_t)index * (json_int_t)sizeof *e->index, "componentType",
                                  UNSIGNED_INT, "count", e->index_count - index, "type", "SCALAR"));
    int material = export_material(e, shown->key / EXPORT_LOOKS, (ExportLook)(shown->key % EXPORT_LOOKS));
    return json_pack("{s:{s:i s:i} s:i s:i}", "attributes", "POSITION", positions, "COLOR_0", colours,
                     "indices", indices, "material", material);
}

int export_mesh(Export *e, const ExportTree *tree, const ExportNode *node) {
    ShownList list = {0};
    list_shown(e, tree, node, &list);
    json_t *primitives = json_array();
    for (int i = 0, end; i < list.count; i = end) {
        for (end = i; end < list.count && list.shown[end].key == list.shown[i].key;) end++;
        json_array_append_new(primitives, add_primitive(e, node, list.shown + i, end - i));
    }
    arena_free(&list.arena);
    json_array_append_new(e->meshes,
                          json_pack("{s:o s:o}", "name", export_text(node->name), "primitives", primitives));
    return (int)json_array_size(e->meshes) - 1;
}
