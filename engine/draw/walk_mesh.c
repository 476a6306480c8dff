// walk_mesh.c - one vertex buffer for both looks, and an index buffer written anew each frame: one draw call with the nearest polygons
// first costs a software rasteriser far less than hundreds of calls in the order of the file.
#include "engine/draw/walk_mesh.h"

#include <glad/gl.h>
#include <stdlib.h>

#include "engine/core/polygon.h"
#include "engine/draw/lit_mesh.h"
#include "engine/shade/walk_bake.h"

typedef struct WalkVertex {
    float position[3], normal[3];
    uint8_t colour[4], emission[4];  // for the fine look; colour: square root of the reflectance, alpha
    int16_t lamps[2];
    Rgba8 front, back;  // for the fast look, as seen from either side; of a surface in usual light
    float place[2];     // for surfaces: the place in the atlas
} WalkVertex;

typedef struct Ordered {
    double distance;
    int object;
} Ordered;

struct WalkMesh {
    const CellGraph *graph;
    const WalkTextures *textures;
    Vec3 origin;
    WalkLights lights;
    WalkBake *bake;
    WalkAtlas atlas;                // its texels are in OpenGL's memory
    int *first_vertex;              // [polygon_count + 1] in the vertex buffer
    int *first_index;               // [polygon_count + 1] in `index`
    unsigned *index;                // triangles of all polygons
    Plane *plane;                   // [polygon_count]
    unsigned char *has_glass;       // [object_count]
    unsigned char *run;             // [polygon_count] as in walk_textures.h
    unsigned char *runs;            // [object_count] bit i: some polygon is of run i
    const unsigned char *left_out;  // of the list being made
    float *share;                   // [leaf_count] how far leaves are open; NAN before the first pose
    WalkVertex *moved;              // room for the vertices of any one leaf, and for its corners
    Vec3 *corners;
    Ordered *order;                   // [object_count] of the list being made
    unsigned *list;                   // the frame's indices, as uploaded
    int end[WALK_PARTS * WALK_RUNS];  // in `list`: where each run of each part ends and the next begins
    unsigned picture_buffer;          // 0: nothing has a picture
    unsigned array, vertex_buffer, list_buffer, once_buffer, lamp_buffer, lamp_texture, atlas_texture;
};

Vec3 walk_mesh_origin(const WalkMesh *mesh) { return mesh->origin; }

// ---- vertices

// Writes the vertices of a polygon whose corners are `v` at the moment.
static void fill_polygon(const WalkMesh *mesh, int polygon, int object, const Vec3 *v, WalkVertex *out) {
    const Polygon *p = &mesh->graph->polygons[polygon];
    const Material *m = &mesh->graph->building->materials[p->material];
    bool surface = mesh->graph->objects[object].kind == OBJECT_SURFACE;
    Vec3 n = plane_of_polygon(v, p->vertex_count).n;
    Rgb c = m->reflectance, glow = walk_glow(m);
    WalkVertex vertex = {
        .normal = {(float)n.x, (float)n.y, (float)n.z},
        .colour = {walk_byte(sqrtf(c.r)), walk_byte(sqrtf(c.g)), walk_byte(sqrtf(c.b)), walk_byte(m->alpha)},
        .emission = {walk_byte(glow.r), walk_byte(glow.g), walk_byte(glow.b),
                     walk_outdoors(mesh->graph, &mesh->lights, object) ? 255 : 0},
        .lamps = {(int16_t)mesh->lights.first[object], (int16_t)mesh->lights.count[object]}};
    for (int i = 0; i < p->vertex_count; i++) {
        Vec3 at = vec3_sub(v[i], mesh->origin);
        out[i] = vertex;
        out[i].position[0] = (float)at.x;
        out[i].position[1] = (float)at.y;
        out[i].position[2] = (float)at.z;
        if (surface) {
            Vec2 place = walk_bake_place(mesh->bake, &mesh->atlas, polygon, v[i]);
            out[i].place[0] = (float)place.x;
            out[i].place[1] = (float)place.y;
        }
        if (surface && m->alpha == 1) {
            out[i].front = walk_bake_surface(mesh->bake, polygon);
        } else {
            out[i].front = walk_bake_point(mesh->bake, object, p->material, v[i], n);
            out[i].back = walk_bake_point(mesh->bake, object, p->material, v[i], vec3_scale(n, -1));
        }
    }
}

static int object_vertices(const WalkMesh *mesh, int object) {
    const Object *o = &mesh->graph->objects[object];
    return mesh->first_vertex[o->first_polygon + o->polygon_count] - mesh->first_vertex[o->first_polygon];
}

static void move_leaf(WalkMesh *mesh, int object, double open) {
    const CellGraph *graph = mesh->graph;
    const Object *o = &graph->objects[object];
    const Leaf *leaf = &graph->building->leaves[o->leaf];
    int first = mesh->first_vertex[o->first_polygon];
    for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++) {
        const Polygon *polygon = &graph->polygons[p];
        for (int i = 0; i < polygon->vertex_count; i++)
            mesh->corners[i] = leaf_point(leaf, open, graph->vertices[polygon->first_vertex + i]);
        fill_polygon(mesh, p, object, mesh->corners, mesh->moved + (mesh->first_vertex[p] - first));
    }
    glBufferSubData(GL_ARRAY_BUFFER, (GLintptr)((size_t)first * sizeof(WalkVertex)),
                    (GLsizeiptr)((size_t)object_vertices(mesh, object) * sizeof(WalkVertex)), mesh->moved);
}

void walk_mesh_pose(WalkMesh *mesh, const float *door_open) {
    const Building *b = mesh->graph->building;
    glBindBuffer(GL_ARRAY_BUFFER, mesh->vertex_buffer);
    for (int o = 0; o < b->object_count; o++) {
        int leaf = mesh->graph->objects[o].leaf;
        if (leaf < 0) continue;
        float share = door_open ? door_open[b->leaves[leaf].opening] : 1;
        if (mesh->share[leaf] != share) move_leaf(mesh, o, (double)share);
    }
    // Updated only now, because several objects may be parts of one leaf.
    for (int i = 0; i < b->leaf_count; i++) mesh->share[i] = door_open ? door_open[b->leaves[i].opening] : 1;
}

// ---- upload

static void count_all(WalkMesh *mesh, Arena *arena) {
    const CellGraph *graph = mesh->graph;
    int vertices = 0, indices = 0, most = 0;
    for (int p = 0; p < graph->polygon_count; p++) {
        mesh->first_vertex[p] = vertices;
        mesh->first_index[p] = indices;
        vertices += graph->polygons[p].vertex_count;
        indices += 3 * (graph->polygons[p].vertex_count - 2);
    }
    mesh->first_vertex[graph->polygon_count] = vertices;
    mesh->first_index[graph->polygon_count] = indices;
    for (int o = 0; o < graph->object_count; o++) {
        if (graph->objects[o].leaf >= 0 && object_vertices(mesh, o) > most) most = object_vertices(mesh, o);
    }
    mesh->moved = ARENA_ARRAY(arena, WalkVertex, most + 1);
    mesh->corners = ARENA_ARRAY(arena, Vec3, most + 1);
    mesh->index = ARENA_ARRAY(arena, unsigned, indices + 1);
    // Edges drawn as lines need two indices each.
    mesh->list = ARENA_ARRAY(arena, unsigned, (indices > 2 * vertices ? indices : 2 * vertices) + 1);
}

static void fill_indices(WalkMesh *mesh) {
    const CellGraph *graph = mesh->graph;
    for (int o = 0; o < graph->object_count; o++) {
        const Object *object = &graph->objects[o];
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++) {
            const Polygon *polygon = &graph->polygons[p];
            const Vec3 *v = graph->vertices + polygon->first_vertex;
            int *triangle = (int *)(mesh->index + mesh->first_index[p]);
            polygon_triangulate(v, polygon->vertex_count, triangle);
            for (int k = 0; k < 3 * (polygon->vertex_count - 2); k++) triangle[k] += mesh->first_vertex[p];
            mesh->plane[p] = plane_of_polygon(v, polygon->vertex_count);
            if (vis_is_glass(graph, p)) mesh->has_glass[o] = 1;
            mesh->run[p] = (unsigned char)walk_textures_run(mesh->textures, polygon);
            mesh->runs[o] |= (unsigned char)(1 << mesh->run[p]);
        }
    }
}

static void describe_vertices(void) {
    static const struct {
        int size;
        unsigned type;
        size_t offset;
    } FLOATS[] = {[0] = {3, GL_FLOAT, offsetof(WalkVertex, position)},
                  [1] = {3, GL_FLOAT, offsetof(WalkVertex, normal)},
                  [2] = {4, GL_UNSIGNED_BYTE, offsetof(WalkVertex, colour)},
                  [3] = {4, GL_UNSIGNED_BYTE, offsetof(WalkVertex, emission)},
                  [5] = {4, GL_UNSIGNED_BYTE, offsetof(WalkVertex, front)},
                  [6] = {4, GL_UNSIGNED_BYTE, offsetof(WalkVertex, back)},
                  [7] = {2, GL_FLOAT, offsetof(WalkVertex, place)}};
    GLsizei stride = sizeof(WalkVertex);
    for (unsigned i = 0; i < sizeof FLOATS / sizeof *FLOATS; i++) {
        glEnableVertexAttribArray(i);
        if (FLOATS[i].size == 0) continue;
        bool normalized = FLOATS[i].type == GL_UNSIGNED_BYTE;
        glVertexAttribPointer(i, FLOATS[i].size, FLOATS[i].type, normalized, stride,
                              (const void *)FLOATS[i].offset);
    }
    glVertexAttribIPointer(4, 2, GL_SHORT, stride, (const void *)offsetof(WalkVertex, lamps));
}

static void upload_pictures(WalkMesh *mesh, Arena *scratch) {
    const CellGraph *graph = mesh->graph;
    if (walk_textures_runs(mesh->textures) == 1) return;
    size_t count = (size_t)mesh->first_vertex[graph->polygon_count];
    WalkPicture *picture = ARENA_ARRAY(scratch, WalkPicture, count + 1);
    for (int p = 0; p < graph->polygon_count; p++) {
        const Polygon *polygon = &graph->polygons[p];
        const Vec3 *corners = graph->vertices + polygon->first_vertex;
        walk_textures_place(mesh->textures, polygon, corners[0], corners, polygon->vertex_count,
                            picture + mesh->first_vertex[p]);
    }
    glGenBuffers(1, &mesh->picture_buffer);
    walk_textures_describe(mesh->picture_buffer);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(count * sizeof *picture), picture, GL_STATIC_DRAW);
}

static void upload_vertices(WalkMesh *mesh) {
    const CellGraph *graph = mesh->graph;
    Arena scratch = {0};
    size_t count = (size_t)mesh->first_vertex[graph->polygon_count];
    WalkVertex *vertex = ARENA_ARRAY(&scratch, WalkVertex, count + 1);
#pragma omp parallel for schedule(dynamic, 8)
    for (int o = 0; o < graph->object_count; o++) {
        const Object *object = &graph->objects[o];
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++) {
            fill_polygon(mesh, p, o, graph->vertices + graph->polygons[p].first_vertex,
                         vertex + mesh->first_vertex[p]);
        }
    }
    glGenVertexArrays(1, &mesh->array);
    glBindVertexArray(mesh->array);
    glGenBuffers(1, &mesh->vertex_buffer);
    glBindBuffer(GL_ARRAY_BUFFER, mesh->vertex_buffer);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(count * sizeof *vertex), vertex, GL_STATIC_DRAW);
    describe_vertices();
    upload_pictures(mesh, &scratch);
    glGenBuffers(1, &mesh->list_buffer);
    glGenBuffers(1, &mesh->once_buffer);
    arena_free(&scratch);
}

static void upload_lamps(WalkMesh *mesh) {
    glGenBuffers(1, &mesh->lamp_buffer);
    glBindBuffer(GL_TEXTURE_BUFFER, mesh->lamp_buffer);
    glBufferData(GL_TEXTURE_BUFFER, (GLsizeiptr)((size_t)(mesh->lights.lamp_count + 1) * sizeof(WalkLamp)),
                 mesh->lights.lamps, GL_STATIC_DRAW);
    glGenTextures(1, &mesh->lamp_texture);
    glActiveTexture(GL_TEXTURE0 + WALK_UNIT_LAMPS);
    glBindTexture(GL_TEXTURE_BUFFER, mesh->lamp_texture);
    glTexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, mesh->lamp_buffer);
}

static bool upload_atlas(WalkMesh *mesh, Error *error) {
    Arena scratch = {0};
    int most = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    bool good = walk_bake_surfaces(mesh->bake, most, &scratch, &mesh->atlas, error);
    if (good) {
        glGenTextures(1, &mesh->atlas_texture);
        glActiveTexture(GL_TEXTURE0 + WALK_UNIT_ATLAS);
        glBindTexture(GL_TEXTURE_2D, mesh->atlas_texture);
        glTexImage2D(GL_TEXTURE_2D, 0, GL_R16F, mesh->atlas.width, mesh->atlas.height, 0, GL_RED, GL_FLOAT,
                     mesh->atlas.texels);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    }
    mesh->atlas.texels = NULL;
    arena_free(&scratch);
    return good;
}

static bool upload(WalkMesh *mesh, Error *error) {
    fill_indices(mesh);
    if (!upload_atlas(mesh, error)) return false;
    upload_lamps(mesh);
    upload_vertices(mesh);
    walk_mesh_pose(mesh, NULL);
    return true;
}

WalkMesh *walk_mesh_new(const CellGraph *graph, const WalkTextures *textures, Arena *arena, Error *error) {
    WalkMesh *mesh = ARENA_ARRAY(arena, WalkMesh, 1);
    mesh->graph = graph;
    mesh->textures = textures;
    mesh->origin = lit_origin(graph);
    mesh->lights = walk_lights(graph, mesh->origin, arena);
    mesh->bake = walk_bake_new(graph, &mesh->lights, mesh->origin, arena);
    mesh->first_vertex = ARENA_ARRAY(arena, int, graph->polygon_count + 1);
    mesh->first_index = ARENA_ARRAY(arena, int, graph->polygon_count + 1);
    mesh->plane = ARENA_ARRAY(arena, Plane, graph->polygon_count + 1);
    mesh->has_glass = ARENA_ARRAY(arena, unsigned char, graph->object_count + 1);
    mesh->run = ARENA_ARRAY(arena, unsigned char, graph->polygon_count + 1);
    mesh->runs = ARENA_ARRAY(arena, unsigned char, graph->object_count + 1);
    mesh->order = ARENA_ARRAY(arena, Ordered, graph->object_count + 1);
    mesh->share = ARENA_ARRAY(arena, float, graph->building->leaf_count + 1);
    for (int i = 0; i < graph->building->leaf_count; i++) mesh->share[i] = NAN;
    count_all(mesh, arena);
    if (upload(mesh, error)) return mesh;
    walk_mesh_free(mesh);
    return NULL;
}

void walk_mesh_free(WalkMesh *mesh) {
    if (!mesh) return;
    unsigned buffers[] = {mesh->vertex_buffer, mesh->list_buffer, mesh->once_buffer, mesh->lamp_buffer,
                          mesh->picture_buffer};
    unsigned textures[] = {mesh->lamp_texture, mesh->atlas_texture};
    glDeleteVertexArrays(1, &mesh->array);
    glDeleteBuffers(5, buffers);
    glDeleteTextures(2, textures);
}

// ---- draw lists

static int by_distance(const void *p, const void *q) {
    const Ordered *a = p, *b = q;
    if (a->distance != b->distance) return a->distance < b->distance ? -1 : 1;
    return (a->object > b->object) - (a->object < b->object);
}

static double distance_to_box(Box box, Vec3 p) {
    Vec3 off =
        vec3(fmax(0, fmax(box.min.x - p.x, p.x - box.max.x)), fmax(0, fmax(box.min.y - p.y, p.y - box.max.y)),
             fmax(0, fmax(box.min.z - p.z, p.z - box.max.z)));
    return vec3_length(off);
}

static int mesh_polygon(WalkMesh *mesh, int polygon, int at) {
    int first = mesh->first_index[polygon], count = mesh->first_index[polygon + 1] - first;
    memcpy(mesh->list + at, mesh->index + first, (size_t)count * sizeof *mesh->list);
    return at + count;
}

static int add_object(WalkMesh *mesh, int object, int part, int run, Vec3 eye, int at) {
    const Object *o = &mesh->graph->objects[object];
    if (!(mesh->runs[object] & 1 << run)) return at;
    for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++) {
        if (mesh->run[p] != run || (mesh->left_out && mesh->left_out[p])) continue;
        if (mesh->has_glass[object] && vis_is_glass(mesh->graph, p) != (part == WALK_PANES)) continue;
        // Where two surfaces lie back to back, neither may hide the other: each is seen only from inside its own cell.
        if (part == WALK_SURFACES && plane_distance(mesh->plane[p], eye) <= 0) continue;
        at = mesh_polygon(mesh, p, at);
    }
    return at;
}

static int list_part(WalkMesh *mesh, int part, Vec3 eye, const int *objects, int count, int at) {
    int chosen = 0;
    for (int i = 0; i < count; i++) {
        int o = objects[i];
        bool surface = mesh->graph->objects[o].kind == OBJECT_SURFACE;
        if (part == WALK_PANES ? !mesh->has_glass[o] : surface != (part == WALK_SURFACES)) continue;
        Box box = mesh->graph->object_boxes[o];
        // Panes are blended over what is behind them: the farthest middle comes first. In other parts the nearest box comes first.
        double distance = part == WALK_PANES ? -vec3_length(vec3_sub(vec3_lerp(box.min, box.max, 0.5), eye))
                                             : distance_to_box(box, eye);
        mesh->order[chosen++] = (Ordered){distance, o};
    }
    qsort(mesh->order, (size_t)chosen, sizeof *mesh->order, by_distance);
    for (int run = 0; run < WALK_RUNS; run++) {
        for (int i = 0; i < chosen && run < walk_textures_runs(mesh->textures); i++)
            at = add_object(mesh, mesh->order[i].object, part, run, eye, at);
        mesh->end[part * WALK_RUNS + run] = at;
    }
    return at;
}

void walk_mesh_list(WalkMesh *mesh, Vec3 eye, const int *objects, int count, const unsigned char *left_out) {
    int at = 0;
    mesh->left_out = left_out;
    for (int part = 0; part < WALK_PARTS; part++) at = list_part(mesh, part, eye, objects, count, at);
    glBindVertexArray(mesh->array);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, mesh->list_buffer);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)((size_t)at * sizeof *mesh->list), mesh->list,
                 GL_STREAM_DRAW);
}

void walk_mesh_bind(const WalkMesh *mesh) {
    glBindVertexArray(mesh->array);
    glActiveTexture(GL_TEXTURE0 + WALK_UNIT_LAMPS);
    glBindTexture(GL_TEXTURE_BUFFER, mesh->lamp_texture);
    glActiveTexture(GL_TEXTURE0 + WALK_UNIT_ATLAS);
    glBindTexture(GL_TEXTURE_2D, mesh->atlas_texture);
}

void walk_mesh_draw(const WalkMesh *mesh, int part, int run) {
    int from = part * WALK_RUNS + (run == WALK_ALL_RUNS ? 0 : run),
        to = run == WALK_ALL_RUNS ? from + WALK_RUNS - 1 : from;
    int first = from > 0 ? mesh->end[from - 1] : 0, count = mesh->end[to] - first;
    if (count == 0) return;
    glDrawElements(GL_TRIANGLES, count, GL_UNSIGNED_INT, (const void *)((size_t)first * sizeof *mesh->list));
}

// Draws the first `count` indices of mesh->list, beside the draw list that was uploaded.
static void draw_once(const WalkMesh *mesh, int count, unsigned primitive) {
    glBindVertexArray(mesh->array);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, mesh->once_buffer);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)((size_t)count * sizeof *mesh->list), mesh->list,
                 GL_STREAM_DRAW);
    glDrawElements(primitive, count, GL_UNSIGNED_INT, NULL);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, mesh->list_buffer);
}

void walk_mesh_draw_polygons(WalkMesh *mesh, const int *polygons, int count) {
    int at = 0;
    for (int i = 0; i < count; i++) at = mesh_polygon(mesh, polygons[i], at);
    draw_once(mesh, at, GL_TRIANGLES);
}

void walk_mesh_draw_edges(WalkMesh *mesh, const int *objects, int object_count) {
    const CellGraph *graph = mesh->graph;
    int count = 0;
    for (int k = 0; k < object_count; k++) {
        const Object *o = &graph->objects[objects[k]];
        for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++) {
            unsigned first = (unsigned)mesh->first_vertex[p],
                     corners = (unsigned)graph->polygons[p].vertex_count;
            for (unsigned i = 0; i < corners; i++) {
                mesh->list[count++] = first + i;
                mesh->list[count++] = first + (i + 1) % corners;
            }
        }
    }
    draw_once(mesh, count, GL_LINES);
}
