// walk_lit.c - elements as triangles, in the order of the graph's polygons; of leaves, which move, polygons whole. What the
// mesh lacks (glass) is left to others.
#include "engine/walk/walk_lit.h"

#include <glad/gl.h>

#include "engine/core/polygon.h"

typedef struct LitVertex {
    float position[3], normal[3];
    Rgba8 front, back;
} LitVertex;

struct WalkLit {
    const CellGraph *graph;
    Vec3 origin;
    int *first_vertex, *first_index;  // [polygon_count + 1] in `vertex` and `index`
    LitVertex *vertex;                // of leaves, the corners of their polygons
    unsigned *index;
    Plane *plane;     // [polygon_count] of surfaces
    float *share;     // [leaf_count] where leaves stand
    unsigned *list;   // of the frame
    int things, all;  // indices in it: of things, and with the surfaces
    unsigned array, vertex_buffer, list_buffer;
};

// The back of a face reflects nothing, as light is computed. Curtains and leaves are one polygon all the same: they show
// three quarters of their front's light.
static Rgba8 back_of(Rgba8 front) {
    return (Rgba8){(uint8_t)(front.r * 3 / 4), (uint8_t)(front.g * 3 / 4), (uint8_t)(front.b * 3 / 4), 255};
}

static void put_vertex(const WalkLit *lit, LitVertex *out, Vec3 at, Vec3 n, Rgba8 front) {
    Vec3 p = vec3_sub(at, lit->origin);
    *out = (LitVertex){
        {(float)p.x, (float)p.y, (float)p.z}, {(float)n.x, (float)n.y, (float)n.z}, front, back_of(front)};
}

static bool is_leaf(const CellGraph *graph, int object) { return graph->objects[object].leaf >= 0; }

// How much of each a polygon takes.
static void count_polygon(const WalkLight *light, int object, int polygon, int *vertices, int *indices) {
    const Mesh *mesh = light->mesh;
    int f = mesh->face_of[polygon], corners = mesh->graph->polygons[polygon].vertex_count;
    *vertices = *indices = 0;
    if (f < 0) return;
    if (is_leaf(mesh->graph, object)) {
        *vertices = corners;
        *indices = 3 * (corners - 2);
        return;
    }
    const Face *face = &mesh->faces[f];
    for (int e = face->first_element; e < face->first_element + face->element_count; e++) {
        *vertices += mesh->elements[e].corner_count;
        *indices += 3 * (mesh->elements[e].corner_count - 2);
    }
}

static void count_all(WalkLit *lit, const WalkLight *light, Arena *arena) {
    const CellGraph *graph = lit->graph;
    int vertices = 0, indices = 0;
    lit->first_vertex = ARENA_ARRAY(arena, int, graph->polygon_count + 1);
    lit->first_index = ARENA_ARRAY(arena, int, graph->polygon_count + 1);
    for (int o = 0; o < graph->object_count; o++) {
        const Object *object = &graph->objects[o];
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++) {
            int v, i;
            lit->first_vertex[p] = vertices;
            lit->first_index[p] = indices;
            count_polygon(light, o, p, &v, &i);
            vertices += v;
            indices += i;
        }
    }
    lit->first_vertex[graph->polygon_count] = vertices;
    lit->first_index[graph->polygon_count] = indices;
    lit->vertex = ARENA_ARRAY(arena, LitVertex, vertices + 1);
    lit->index = ARENA_ARRAY(arena, unsigned, indices + 1);
    lit->list = ARENA_ARRAY(arena, unsigned, indices + 1);
    lit->plane = ARENA_ARRAY(arena, Plane, graph->polygon_count + 1);
}

static void triangulate(WalkLit *lit, const Vec3 *v, int count, int vertex, int index) {
    int *triangle = (int *)(lit->index + index);
    polygon_triangulate(v, count, triangle);
    for (int k = 0; k < 3 * (count - 2); k++) triangle[k] += vertex;
}

static void fill_elements(WalkLit *lit, const WalkLight *light, const WalkShades *shades, int polygon,
                          Arena *scratch) {
    const Mesh *mesh = light->mesh;
    const Face *face = &mesh->faces[mesh->face_of[polygon]];
    int vertex = lit->first_vertex[polygon], index = lit->first_index[polygon];
    for (int e = face->first_element; e < face->first_element + face->element_count; e++) {
        const Element *element = &mesh->elements[e];
        Vec3 *v = ARENA_ARRAY(scratch, Vec3, element->corner_count);
        for (int i = 0; i < element->corner_count; i++) {
            int corner = element->first_corner + i;
            v[i] = mesh->vertices[mesh->corners[corner]];
            put_vertex(lit, &lit->vertex[vertex + i], v[i], face->plane.n, shades->corner[corner]);
        }
        triangulate(lit, v, element->corner_count, vertex, index);
        vertex += element->corner_count;
        index += 3 * (element->corner_count - 2);
    }
}

// As it is drawn; pose puts it in its place.
static void fill_leaf(WalkLit *lit, const WalkLight *light, const WalkShades *shades, int polygon) {
    const Polygon *p = &lit->graph->polygons[polygon];
    const Vec3 *v = lit->graph->vertices + p->first_vertex;
    int face = light->mesh->face_of[polygon], vertex = lit->first_vertex[polygon];
    for (int i = 0; i < p->vertex_count; i++)
        put_vertex(lit, &lit->vertex[vertex + i], v[i], light->mesh->faces[face].plane.n, shades->face[face]);
    triangulate(lit, v, p->vertex_count, vertex, lit->first_index[polygon]);
}

static void fill_all(WalkLit *lit, const WalkLight *light) {
    const CellGraph *graph = lit->graph;
    Arena arena = {0}, scratch = {0};
    WalkShades shades = walk_light_shades(light, &arena);
    for (int o = 0; o < graph->object_count; o++) {
        const Object *object = &graph->objects[o];
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++) {
            int face = light->mesh->face_of[p];
            if (face < 0) continue;
            lit->plane[p] = light->mesh->faces[face].plane;
            arena_reset(&scratch);
            if (is_leaf(graph, o))
                fill_leaf(lit, light, &shades, p);
            else
                fill_elements(lit, light, &shades, p, &scratch);
        }
    }
    arena_free(&arena);
    arena_free(&scratch);
}

// Places as of the shader for what stands in rooms.
static void describe_vertices(void) {
    static const struct {
        unsigned place;
        int size;
        unsigned type;
        size_t offset;
    } PARTS[] = {{0, 3, GL_FLOAT, offsetof(LitVertex, position)},
                 {1, 3, GL_FLOAT, offsetof(LitVertex, normal)},
                 {5, 4, GL_UNSIGNED_BYTE, offsetof(LitVertex, front)},
                 {6, 4, GL_UNSIGNED_BYTE, offsetof(LitVertex, back)}};
    for (size_t i = 0; i < sizeof PARTS / sizeof *PARTS; i++) {
        glEnableVertexAttribArray(PARTS[i].place);
        glVertexAttribPointer(PARTS[i].place, PARTS[i].size, PARTS[i].type, PARTS[i].type == GL_UNSIGNED_BYTE,
                              sizeof(LitVertex), (const void *)PARTS[i].offset);
    }
}

WalkLit *walk_lit_new(const WalkLight *light, Vec3 origin, Arena *arena) {
    WalkLit *lit = ARENA_ARRAY(arena, WalkLit, 1);
    const CellGraph *graph = light->mesh->graph;
    lit->graph = graph;
    lit->origin = origin;
    lit->share = ARENA_ARRAY(arena, float, graph->building->leaf_count + 1);
    for (int i = 0; i < graph->building->leaf_count; i++) lit->share[i] = NAN;
    count_all(lit, light, arena);
    fill_all(lit, light);
    glGenVertexArrays(1, &lit->array);
    glBindVertexArray(lit->array);
    glGenBuffers(1, &lit->vertex_buffer);
    glBindBuffer(GL_ARRAY_BUFFER, lit->vertex_buffer);
    glBufferData(GL_ARRAY_BUFFER,
                 (GLsizeiptr)((size_t)lit->first_vertex[graph->polygon_count] * sizeof *lit->vertex),
                 lit->vertex, GL_STATIC_DRAW);
    describe_vertices();
    glGenBuffers(1, &lit->list_buffer);
    walk_lit_pose(lit, NULL);
    return lit;
}

void walk_lit_free(WalkLit *lit) {
    if (!lit) return;
    unsigned buffers[] = {lit->vertex_buffer, lit->list_buffer};
    glDeleteVertexArrays(1, &lit->array);
    glDeleteBuffers(2, buffers);
}

static void move_leaf(WalkLit *lit, int object, double open) {
    const CellGraph *graph = lit->graph;
    const Object *o = &graph->objects[object];
    const Leaf *leaf = &graph->building->leaves[o->leaf];
    int first = lit->first_vertex[o->first_polygon],
        end = lit->first_vertex[o->first_polygon + o->polygon_count];
    for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++) {
        const Polygon *polygon = &graph->polygons[p];
        LitVertex *vertex = lit->vertex + lit->first_vertex[p];
        if (lit->first_vertex[p + 1] == lit->first_vertex[p]) continue;
        Vec3 corner[3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, n = lit->plane[p].n;
        for (int i = 0; i < polygon->vertex_count; i++) {
            Vec3 at = leaf_point(leaf, open, graph->vertices[polygon->first_vertex + i]);
            if (i < 3) corner[i] = at;
            put_vertex(lit, &vertex[i], at, n, vertex[i].front);
        }
        n = vec3_normalize(vec3_cross(vec3_sub(corner[1], corner[0]), vec3_sub(corner[2], corner[0])));
        for (int i = 0; i < polygon->vertex_count; i++) {
            vertex[i].normal[0] = (float)n.x;
            vertex[i].normal[1] = (float)n.y;
            vertex[i].normal[2] = (float)n.z;
        }
    }
    glBufferSubData(GL_ARRAY_BUFFER, (GLintptr)((size_t)first * sizeof *lit->vertex),
                    (GLsizeiptr)((size_t)(end - first) * sizeof *lit->vertex), lit->vertex + first);
}

void walk_lit_pose(WalkLit *lit, const float *door_open) {
    const Building *b = lit->graph->building;
    glBindBuffer(GL_ARRAY_BUFFER, lit->vertex_buffer);
    for (int o = 0; o < b->object_count; o++) {
        int leaf = lit->graph->objects[o].leaf;
        if (leaf < 0) continue;
        float share = door_open ? door_open[b->leaves[leaf].opening] : 1;
        if (lit->share[leaf] != share) move_leaf(lit, o, (double)share);
    }
    for (int i = 0; i < b->leaf_count; i++) lit->share[i] = door_open ? door_open[b->leaves[i].opening] : 1;
}

static int add_objects(WalkLit *lit, Vec3 eye, const int *objects, int count, bool surfaces, int at) {
    const CellGraph *graph = lit->graph;
    for (int k = 0; k < count; k++) {
        const Object *o = &graph->objects[objects[k]];
        if ((o->kind == OBJECT_SURFACE) != surfaces) continue;
        for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++) {
            // As in the other looks: where two surfaces lie back to back, each is seen from inside its cell only.
            if (surfaces && plane_distance(lit->plane[p], eye) <= 0) continue;
            int indices = lit->first_index[p + 1] - lit->first_index[p];
            memcpy(lit->list + at, lit->index + lit->first_index[p], (size_t)indices * sizeof *lit->list);
            at += indices;
        }
    }
    return at;
}

void walk_lit_list(WalkLit *lit, Vec3 eye, const int *objects, int object_count) {
    lit->things = add_objects(lit, eye, objects, object_count, false, 0);
    lit->all = add_objects(lit, eye, objects, object_count, true, lit->things);
    glBindVertexArray(lit->array);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, lit->list_buffer);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)((size_t)lit->all * sizeof *lit->list), lit->list,
                 GL_STREAM_DRAW);
}

void walk_lit_draw(const WalkLit *lit, bool surfaces) {
    int first = surfaces ? lit->things : 0, count = surfaces ? lit->all - lit->things : lit->things;
    if (count == 0) return;
    glBindVertexArray(lit->array);
    glDrawElements(GL_TRIANGLES, count, GL_UNSIGNED_INT, (const void *)((size_t)first * sizeof *lit->list));
}
