// walk_lit.c - two buffers of light: while one is shown, the next state of the light is written to the other, a slice a frame; then the
// shader fades from the first to the second. No frame waits for a large building, and none shows half a state.
#include "engine/draw/walk_lit.h"

#include <glad/gl.h>

#include "engine/draw/walk_mesh.h"
#include "engine/lit/lit_leaf.h"

struct WalkLit {
    Arena arena;
    LitMesh *mesh;
    float *open;  // [opening_count] how far doors are open
    float *
        share;  // [object_count] how far the door was open as a leaf or a plug was drawn last; NAN: never, in this light
    const LitLight *light;   // of leaves and plugs; NULL: none yet
    float (*leaf)[3];        // the light of a leaf or a plug under way, [vertices of the largest]
    LitVertex *moved;        // and a leaf where it stands
    unsigned *list;          // indices of the frame's triangles
    int end[2 * WALK_RUNS];  // in `list`: where each run of things ends, then of surfaces
    const WalkTextures *textures;
    WalkPicture *picture;                // [vertex_count], or NULL: nothing has a picture
    unsigned char *run;                  // [face_count] as in walk_textures.h
    int vertices_there, pictures_there;  // vertices uploaded so far of LitMesh, and of `picture`
    int light_there,
        newest;  // vertices of the arriving light uploaded so far; the newest complete buffer, -1: none
    double fade;
    unsigned picture_buffer;
    WalkLitRoom room;
    unsigned array, list_buffer, material_buffer, material_texture;
};

// ---- upload

// Locations of the vertex attributes in the shaders.
enum {
    PLACE_POSITION = 0,
    PLACE_NORMAL = 1,
    PLACE_KIND = 4,
    PLACE_SHINES = 5,
    PLACE_BEFORE = 8,
    PLACE_LIGHT = 9
};

static void describe_vertices(const WalkLit *lit) {
    GLsizei stride = sizeof(LitVertex);
    glBindVertexArray(lit->array);
    glBindBuffer(GL_ARRAY_BUFFER, lit->room.vertex_buffer);
    glVertexAttribPointer(PLACE_POSITION, 3, GL_FLOAT, GL_FALSE, stride,
                          (const void *)offsetof(LitVertex, position));
    glVertexAttribPointer(PLACE_NORMAL, 3, GL_FLOAT, GL_FALSE, stride,
                          (const void *)offsetof(LitVertex, normal));
    glVertexAttribIPointer(PLACE_KIND, 1, GL_INT, stride, (const void *)offsetof(LitVertex, material));
    glVertexAttribIPointer(PLACE_SHINES, 2, GL_UNSIGNED_BYTE, stride,
                           (const void *)offsetof(LitVertex, emits));
    static const unsigned PLACES[] = {PLACE_POSITION, PLACE_NORMAL, PLACE_KIND,
                                      PLACE_SHINES,   PLACE_BEFORE, PLACE_LIGHT};
    for (size_t i = 0; i < sizeof PLACES / sizeof *PLACES; i++) glEnableVertexAttribArray(PLACES[i]);
}

static void describe_light(const WalkLit *lit, unsigned place, int which) {
    glBindVertexArray(lit->array);
    glBindBuffer(GL_ARRAY_BUFFER, lit->room.light_buffer[which]);
    glVertexAttribPointer(place, 3, GL_FLOAT, GL_FALSE, 0, NULL);
}

static unsigned make_buffer(size_t bytes) {
    unsigned buffer;
    glGenBuffers(1, &buffer);
    glBindBuffer(GL_ARRAY_BUFFER, buffer);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)bytes, NULL, GL_STATIC_DRAW);
    return buffer;
}

// Two texels a material: reflectance and radiant exitance, W/m^2.
static void upload_materials(WalkLit *lit) {
    const Building *b = lit->mesh->graph->building;
    Arena scratch = {0};
    float(*texels)[2][4] = arena_alloc(&scratch, (size_t)b->material_count + 1, sizeof *texels);
    for (int i = 0; i < b->material_count; i++) {
        Rgb r = b->materials[i].reflectance, e = b->materials[i].emission;
        float both[2][4] = {{r.r, r.g, r.b, 0}, {e.r, e.g, e.b, 0}};
        memcpy(texels[i], both, sizeof both);
    }
    glGenBuffers(1, &lit->material_buffer);
    glBindBuffer(GL_TEXTURE_BUFFER, lit->material_buffer);
    glBufferData(GL_TEXTURE_BUFFER, (GLsizeiptr)((size_t)(b->material_count + 1) * sizeof *texels), texels,
                 GL_STATIC_DRAW);
    glGenTextures(1, &lit->material_texture);
    walk_lit_bind(lit);
    glTexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, lit->material_buffer);
    arena_free(&scratch);
}

// The place of a vertex; that of a leaf, as when it is closed.
static Vec3 vertex_place(const LitMesh *mesh, int vertex) {
    const float *p = mesh->vertex[vertex].position;
    return vec3_add(vec3((double)p[0], (double)p[1], (double)p[2]), mesh->origin);
}

static void place_pictures(WalkLit *lit, Arena *arena) {
    const LitMesh *mesh = lit->mesh;
    const CellGraph *graph = mesh->graph;
    lit->run = ARENA_ARRAY(arena, unsigned char, mesh->face_count + 1);
    if (walk_textures_runs(lit->textures) == 1) return;
    lit->picture = ARENA_ARRAY(arena, WalkPicture, lit_vertex_count(mesh) + 1);
    for (int f = 0; f < mesh->face_count; f++) {
        const LitFace *face = &mesh->faces[f];
        const Polygon *polygon = &graph->polygons[face->polygon];
        const Vec3 *corners = graph->vertices + polygon->first_vertex;
        lit->run[f] = (unsigned char)walk_textures_run(lit->textures, polygon);
        for (int v = face->first_vertex; v < face[1].first_vertex; v++) {
            Vec3 point = vertex_place(mesh, v);
            walk_textures_place(lit->textures, polygon, corners[0], &point, 1, &lit->picture[v]);
        }
    }
    lit->picture_buffer = make_buffer((size_t)lit_vertex_count(mesh) * sizeof *lit->picture);
    glBindVertexArray(lit->array);
    walk_textures_describe(lit->picture_buffer);
}

// Leaves and plugs are moved and lit anew when they are drawn next.
static void forget_leaves(WalkLit *lit) {
    for (int i = 0; i < lit->mesh->graph->object_count; i++) lit->share[i] = NAN;
}

WalkLitRoom walk_lit_room(int vertices) {
    if (vertices < 1) vertices = 1;
    size_t count = (size_t)vertices;
    return (WalkLitRoom){vertices,
                         make_buffer(count * sizeof(LitVertex)),
                         {make_buffer(count * sizeof(float[3])), make_buffer(count * sizeof(float[3]))}};
}

void walk_lit_room_free(WalkLitRoom *room) {
    unsigned buffers[] = {room->vertex_buffer, room->light_buffer[0], room->light_buffer[1]};
    if (room->vertices > 0) glDeleteBuffers(3, buffers);
    *room = (WalkLitRoom){0};
}

WalkLit *walk_lit_new(LitMesh *mesh, const WalkTextures *textures, WalkLitRoom room) {
    Arena own = {0}, *arena = &own;
    WalkLit *lit = ARENA_ARRAY(arena, WalkLit, 1);
    const CellGraph *graph = mesh->graph;
    int vertices = lit_vertex_count(mesh);
    CORE_ASSERT(room.vertices == 0 || room.vertices >= vertices);
    *lit = (WalkLit){.mesh = mesh, .textures = textures, .newest = -1};
    lit->open = ARENA_ARRAY(arena, float, graph->building->opening_count + 1);
    lit->share = ARENA_ARRAY(arena, float, graph->object_count + 1);
    lit->list = ARENA_ARRAY(arena, unsigned, mesh->faces[mesh->face_count].first_index + 1);
    int most = 0;
    for (int o = 0; o < graph->object_count; o++) {
        const Object *object = &graph->objects[o];
        if (object->leaf < 0 && !object->plug) continue;
        int count = lit_object_end(mesh, object)->first_vertex - lit_object_begin(mesh, object)->first_vertex;
        most = count > most ? count : most;
    }
    lit->leaf = arena_alloc(arena, (size_t)most + 1, sizeof *lit->leaf);
    lit->moved = ARENA_ARRAY(arena, LitVertex, most + 1);
    forget_leaves(lit);
    glGenVertexArrays(1, &lit->array);
    lit->room = room.vertices > 0 ? room : walk_lit_room(vertices);
    describe_vertices(lit);
    place_pictures(lit, arena);
    glGenBuffers(1, &lit->list_buffer);
    upload_materials(lit);
    lit->arena = own;
    return lit;
}

WalkLitRoom walk_lit_end(WalkLit *lit) {
    WalkLitRoom room = lit->room;
    unsigned buffers[] = {lit->list_buffer, lit->material_buffer, lit->picture_buffer};
    glDeleteVertexArrays(1, &lit->array);
    glDeleteBuffers(3, buffers);
    glDeleteTextures(1, &lit->material_texture);
    Arena own = lit->arena;
    arena_free(&own);
    return room;
}

const LitMesh *walk_lit_mesh(const WalkLit *lit) { return lit->mesh; }

// Uploads the next slice of an array of vertices; lessens `bytes` by its size.
static void upload_slice(unsigned buffer, const void *data, size_t size, int count, int *there,
                         size_t *bytes) {
    size_t most = *bytes / size + 1, first = (size_t)*there, left = (size_t)count - first;
    size_t slice = left < most ? left : most;
    if (slice == 0) return;
    glBindBuffer(GL_ARRAY_BUFFER, buffer);
    glBufferSubData(GL_ARRAY_BUFFER, (GLintptr)(first * size), (GLsizeiptr)(slice * size),
                    (const char *)data + first * size);
    *there += (int)slice;
    *bytes = slice * size < *bytes ? *bytes - slice * size : 0;
}

// Lamps shine, or do not, as in this light.
static void switch_lamps(WalkLit *lit, const LitLight *light) {
    const LitMesh *mesh = lit->mesh;
    glBindBuffer(GL_ARRAY_BUFFER, lit->room.vertex_buffer);
    for (int i = 0; i < mesh->lamp_count; i++) {
        const LitFace *lamp = &mesh->faces[mesh->lamp[i]];
        int first = lamp->first_vertex, end = lamp[1].first_vertex;
        if (first == end || mesh->vertex[first].emits == light->on[i]) continue;
        for (int v = first; v < end; v++) mesh->vertex[v].emits = light->on[i];
        glBufferSubData(GL_ARRAY_BUFFER, (GLintptr)((size_t)first * sizeof *mesh->vertex),
                        (GLsizeiptr)((size_t)(end - first) * sizeof *mesh->vertex), mesh->vertex + first);
    }
}

bool walk_lit_upload(WalkLit *lit, const LitLight *light, size_t bytes) {
    int count = lit_vertex_count(lit->mesh), next = lit->newest < 0 ? 0 : 1 - lit->newest;
    upload_slice(lit->room.vertex_buffer, lit->mesh->vertex, sizeof(LitVertex), count, &lit->vertices_there,
                 &bytes);
    if (lit->vertices_there < count || bytes == 0) return false;
    if (lit->picture) {
        upload_slice(lit->picture_buffer, lit->picture, sizeof *lit->picture, count, &lit->pictures_there,
                     &bytes);
        if (lit->pictures_there < count || bytes == 0) return false;
    }
    upload_slice(lit->room.light_buffer[next], light->vertex, sizeof *light->vertex, count, &lit->light_there,
                 &bytes);
    if (lit->light_there < count) return false;
    describe_light(lit, PLACE_BEFORE, lit->newest < 0 ? next : lit->newest);
    describe_light(lit, PLACE_LIGHT, next);
    switch_lamps(lit, light);
    lit->fade = lit->newest < 0 ? 1 : 0;
    lit->newest = next;
    lit->light_there = 0;
    forget_leaves(lit);
    return true;
}

void walk_lit_fade(WalkLit *lit, double share) { lit->fade = fmin(share, 1); }
double walk_lit_faded(const WalkLit *lit) { return lit->fade; }

// ---- doors

static void put_place(float out[3], Vec3 p) {
    out[0] = (float)p.x;
    out[1] = (float)p.y;
    out[2] = (float)p.z;
}

// Uploads lit->leaf as the newest light of an object.
static void put_light(const WalkLit *lit, int object) {
    const LitMesh *mesh = lit->mesh;
    const Object *o = &mesh->graph->objects[object];
    int first = lit_object_begin(mesh, o)->first_vertex, end = lit_object_end(mesh, o)->first_vertex;
    glBindBuffer(GL_ARRAY_BUFFER, lit->room.light_buffer[lit->newest]);
    glBufferSubData(GL_ARRAY_BUFFER, (GLintptr)((size_t)first * sizeof *lit->leaf),
                    (GLsizeiptr)((size_t)(end - first) * sizeof *lit->leaf), lit->leaf);
}

static void move_leaf(WalkLit *lit, int object, double open) {
    const LitMesh *mesh = lit->mesh;
    const CellGraph *graph = mesh->graph;
    const Object *o = &graph->objects[object];
    const Leaf *leaf = &graph->building->leaves[o->leaf];
    int first = lit_object_begin(mesh, o)->first_vertex, end = lit_object_end(mesh, o)->first_vertex;
    for (const LitFace *face = lit_object_begin(mesh, o); face < lit_object_end(mesh, o); face++) {
        const Polygon *polygon = &graph->polygons[face->polygon];
        Vec3 corner[3];
        for (int i = 0; i < 3; i++)
            corner[i] = leaf_point(leaf, open, graph->vertices[polygon->first_vertex + i]);
        Vec3 n = vec3_normalize(vec3_cross(vec3_sub(corner[1], corner[0]), vec3_sub(corner[2], corner[0])));
        for (int v = face->first_vertex; v < face[1].first_vertex; v++) {
            LitVertex *moved = &lit->moved[v - first];
            *moved = mesh->vertex[v];
            put_place(moved->position, vec3_sub(leaf_point(leaf, open, vertex_place(mesh, v)), mesh->origin));
            put_place(moved->normal, n);
        }
    }
    glBindBuffer(GL_ARRAY_BUFFER, lit->room.vertex_buffer);
    glBufferSubData(GL_ARRAY_BUFFER, (GLintptr)((size_t)first * sizeof *mesh->vertex),
                    (GLsizeiptr)((size_t)(end - first) * sizeof *mesh->vertex), lit->moved);
    if (!lit->light || lit->newest < 0) return;
    lit_leaf_light(mesh, lit->light, object, open, lit->leaf);
    put_light(lit, object);
}

// Lights a plug of a door that is closed now and was open when it was baked: then it had no light.
static void light_plug(WalkLit *lit, int object, int opening) {
    if (!lit->light || lit->newest < 0 || !(lit->light->doors[opening] > 0)) return;
    lit_plug_light(lit->mesh, lit->light, object, lit->leaf);
    put_light(lit, object);
}

void walk_lit_pose(WalkLit *lit, const LitLight *light, const float *door_open) {
    const Building *b = lit->mesh->graph->building;
    lit->light = light;
    for (int i = 0; i < b->opening_count; i++) lit->open[i] = door_open ? door_open[i] : 1;
}

// Puts a leaf or a plug that is to be drawn where its door stands. Of a large building few are drawn at a time, and all of them would take
// many frames' time.
static void pose_object(WalkLit *lit, int object) {
    const CellGraph *graph = lit->mesh->graph;
    const Object *o = &graph->objects[object];
    if (o->leaf < 0 && !o->plug) return;
    int opening = o->leaf < 0 ? o->opening : graph->building->leaves[o->leaf].opening;
    float share = lit->open[opening];
    if (lit->share[object] == share) return;
    if (o->leaf >= 0)
        move_leaf(lit, object, (double)share);
    else if (share == 0 && graph->building->openings[opening].leaf_count > 0)
        light_plug(lit, object, opening);
    lit->share[object] = share;
}

static int add_objects(WalkLit *lit, Vec3 eye, const int *objects, int count, const unsigned char *left_out,
                       bool surfaces, int run, int at) {
    const LitMesh *mesh = lit->mesh;
    for (int k = 0; k < count; k++) {
        const Object *o = &mesh->graph->objects[objects[k]];
        if ((o->kind == OBJECT_SURFACE) != surfaces) continue;
        for (const LitFace *face = lit_object_begin(mesh, o); face < lit_object_end(mesh, o); face++) {
            if (left_out && left_out[face->polygon]) continue;
            // As in the other looks: where two surfaces lie back to back, each is seen only from inside its own cell.
            if (lit->run[face - mesh->faces] != run || (surfaces && plane_distance(face->plane, eye) <= 0))
                continue;
            int indices = face[1].first_index - face->first_index;
            memcpy(lit->list + at, mesh->index + face->first_index, (size_t)indices * sizeof *lit->list);
            at += indices;
        }
    }
    return at;
}

void walk_lit_list(WalkLit *lit, Vec3 eye, const int *objects, int object_count,
                   const unsigned char *left_out) {
    int all = 0;
    for (int i = 0; i < object_count; i++) pose_object(lit, objects[i]);
    for (int i = 0; i < 2 * WALK_RUNS; i++) {
        int run = i % WALK_RUNS;
        if (run < walk_textures_runs(lit->textures))
            all = add_objects(lit, eye, objects, object_count, left_out, i >= WALK_RUNS, run, all);
        lit->end[i] = all;
    }
    glBindVertexArray(lit->array);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, lit->list_buffer);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)((size_t)all * sizeof *lit->list), lit->list,
                 GL_STREAM_DRAW);
}

void walk_lit_bind(const WalkLit *lit) {
    glActiveTexture(GL_TEXTURE0 + WALK_UNIT_LAMPS);
    glBindTexture(GL_TEXTURE_BUFFER, lit->material_texture);
}

void walk_lit_draw(const WalkLit *lit, bool surfaces, int run) {
    int from = (surfaces ? WALK_RUNS : 0) + (run == WALK_ALL_RUNS ? 0 : run),
        to = run == WALK_ALL_RUNS ? from + WALK_RUNS - 1 : from;
    int first = from > 0 ? lit->end[from - 1] : 0, count = lit->end[to] - first;
    if (count == 0) return;
    glBindVertexArray(lit->array);
    glDrawElements(GL_TRIANGLES, count, GL_UNSIGNED_INT, (const void *)((size_t)first * sizeof *lit->list));
}
