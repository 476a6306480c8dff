// walk_mesh.c - an index buffer written anew each frame over the vertices of walk_store.c: one draw call with the nearest polygons
// first costs a software rasteriser far less than hundreds of calls in the order of the file.
#include "engine/draw/walk_mesh.h"

#include <glad/gl.h>
#include <stdlib.h>

#include "engine/core/polygon.h"
#include "engine/draw/walk_store.h"
#include "engine/lit/lit_mesh.h"

// Points of light made ahead with one frame: a millisecond or two.
enum { AHEAD_POINTS = 8000 };
// The cells whose view is made ahead: that of the eye, and others around it.
enum { AHEAD_CELLS = 16 };
// The points of edges drawn at a time, an even number: the edges of all hidden objects may be those of a whole campus.
enum { EDGE_POINTS = 1 << 16 };

typedef struct Ordered {
    double distance;
    int object;
} Ordered;

struct WalkMesh {
    const CellGraph *graph;
    const WalkTextures *textures;
    Vec3 origin;
    WalkLights lights;
    WalkStore *store;
    unsigned char *has_glass;       // [object_count]
    unsigned char *runs;            // [object_count] bit i: some polygon is of run i as in walk_textures.h
    const unsigned char *left_out;  // of the list being made
    Ordered *order;                 // [order_capacity] of the list being made
    int *chosen;                    // [chosen_capacity] the panes alone
    unsigned *list;                 // [list_capacity] the frame's indices, as uploaded
    float (*once)[3];               // [once_capacity] points drawn once
    int order_capacity, list_capacity, chosen_capacity, once_capacity;
    int *ahead;  // [ahead_count] the objects that may be seen from `ahead_cell` and around it
    unsigned *cell_listed,
        *object_listed;  // [cell_count], [object_count] the last list ahead in which each was
    unsigned ahead_list;
    int ahead_cell, ahead_count, ahead_capacity;
    bool panes_alone;                 // so was the last list
    int end[WALK_PARTS * WALK_RUNS];  // in `list`: where each run of each part ends and the next begins
    Arena lists;
    unsigned list_buffer, once_array, once_buffer, lamp_buffer, lamp_texture;
};

Vec3 walk_mesh_origin(const WalkMesh *mesh) { return mesh->origin; }

void walk_mesh_pose(WalkMesh *mesh, const float *door_open) { walk_store_pose(mesh->store, door_open); }

// ---- set-up

static void describe_objects(WalkMesh *mesh) {
    const CellGraph *graph = mesh->graph;
    for (int o = 0; o < graph->object_count; o++) {
        const Object *object = &graph->objects[o];
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++) {
            if (vis_is_glass(graph, p)) mesh->has_glass[o] = 1;
            mesh->runs[o] |= (unsigned char)(1 << walk_textures_run(mesh->textures, &graph->polygons[p]));
        }
    }
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

static void make_once(WalkMesh *mesh) {
    glGenVertexArrays(1, &mesh->once_array);
    glGenBuffers(1, &mesh->once_buffer);
    glBindVertexArray(mesh->once_array);
    glBindBuffer(GL_ARRAY_BUFFER, mesh->once_buffer);
    glEnableVertexAttribArray(0);
    glVertexAttribPointer(0, 3, GL_FLOAT, false, sizeof *mesh->once, NULL);
}

WalkMesh *walk_mesh_new(const CellGraph *graph, const WalkTextures *textures, const WalkStoreLimits *limits,
                        Arena *arena, Error *error) {
    WalkMesh *mesh = ARENA_ARRAY(arena, WalkMesh, 1);
    mesh->graph = graph;
    mesh->textures = textures;
    mesh->origin = lit_origin(graph);
    mesh->lights = walk_lights(graph, mesh->origin, arena);
    mesh->has_glass = ARENA_ARRAY(arena, unsigned char, graph->object_count + 1);
    mesh->runs = ARENA_ARRAY(arena, unsigned char, graph->object_count + 1);
    mesh->ahead_cell = -1;
    mesh->cell_listed = ARENA_ARRAY(arena, unsigned, graph->cell_count + 1);
    mesh->object_listed = ARENA_ARRAY(arena, unsigned, graph->object_count + 1);
    describe_objects(mesh);
    mesh->store = walk_store_new(graph, textures, &mesh->lights, mesh->origin, limits, arena, error);
    if (!mesh->store) return NULL;
    upload_lamps(mesh);
    make_once(mesh);
    glGenBuffers(1, &mesh->list_buffer);
    return mesh;
}

void walk_mesh_free(WalkMesh *mesh) {
    if (!mesh) return;
    unsigned buffers[] = {mesh->list_buffer, mesh->once_buffer, mesh->lamp_buffer};
    glDeleteVertexArrays(1, &mesh->once_array);
    glDeleteBuffers(3, buffers);
    glDeleteTextures(1, &mesh->lamp_texture);
    walk_store_free(mesh->store);
    arena_free(&mesh->lists);
}

// ---- ahead

// Has the mark been set since the list was begun? Sets it.
static bool marked(const WalkMesh *mesh, unsigned *mark) {
    bool before = *mark == mesh->ahead_list;
    *mark = mesh->ahead_list;
    return before;
}

static void add_ahead(WalkMesh *mesh, int object) {
    if (!marked(mesh, &mesh->object_listed[object]))
        *ARENA_APPEND(&mesh->lists, mesh->ahead, mesh->ahead_count, mesh->ahead_capacity) = object;
}

// Adds the objects in the cells that may be seen from a cell.
static void add_seen(WalkMesh *mesh, const CellRows *seen, int cell, Arena *scratch) {
    const CellGraph *graph = mesh->graph;
    int *cells = ARENA_ARRAY(scratch, int, cell_rows_size(seen, cell) + 1);
    int count = cell_rows_list(seen, cell, cells);
    for (int i = 0; i < count; i++) {
        if (marked(mesh, &mesh->cell_listed[cells[i]])) continue;
        const SquareGrid *grid = &graph->grids[cells[i]];
        for (int o = graph->surface_first[cells[i]]; o < graph->surface_first[cells[i] + 1]; o++)
            add_ahead(mesh, o);
        for (int k = graph->square_first[grid->first_square];
             k < graph->square_first[grid->first_square + grid->nx * grid->ny]; k++)
            add_ahead(mesh, graph->square_objects[k]);
    }
}

// Lists the objects that may be seen from a cell, then those that may be seen from the cells around it, the nearest first by the number
// of portals between: cells in doorways are passed within a few frames.
static void list_ahead(WalkMesh *mesh, const CellRows *seen, int cell) {
    const CellGraph *graph = mesh->graph;
    Arena scratch = {0};
    int near[AHEAD_CELLS] = {cell}, count = 1;
    mesh->ahead_cell = cell;
    mesh->ahead_count = 0;
    mesh->ahead_list++;
    for (int i = 0; i < count; i++) {
        const Cell *c = &graph->cells[near[i]];
        add_seen(mesh, seen, near[i], &scratch);
        for (int k = c->first_way; k < c->first_way + c->way_count && count < AHEAD_CELLS; k++) {
            bool known = false;
            for (int n = 0; n < count; n++) known = known || near[n] == graph->ways[k].cell;
            if (!known) near[count++] = graph->ways[k].cell;
        }
    }
    arena_free(&scratch);
}

void walk_mesh_ahead(WalkMesh *mesh, const CellRows *seen, int cell) {
    if (cell < 0 || mesh->panes_alone || walk_store_whole(mesh->store)) return;
    if (cell != mesh->ahead_cell) list_ahead(mesh, seen, cell);
    walk_store_hold_ahead(mesh->store, mesh->ahead, mesh->ahead_count, AHEAD_POINTS);
}

WalkStoreFigures walk_mesh_held(const WalkMesh *mesh) { return walk_store_figures(mesh->store); }

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

static bool faces(const CellGraph *graph, const Polygon *p, Vec3 eye) {
    return plane_distance(plane_of_polygon(graph->vertices + p->first_vertex, p->vertex_count), eye) > 0;
}

static int add_object(WalkMesh *mesh, int object, int part, int run, Vec3 eye, int at) {
    const CellGraph *graph = mesh->graph;
    const Object *o = &graph->objects[object];
    if (!(mesh->runs[object] & 1 << run)) return at;
    bool one_run = mesh->runs[object] == 1 << run;
    const unsigned *triangles = walk_store_triangles(mesh->store, object);
    int count = 0;
    for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++, triangles += count) {
        const Polygon *polygon = &graph->polygons[p];
        count = 3 * (polygon->vertex_count - 2);
        if (!one_run && walk_textures_run(mesh->textures, polygon) != run) continue;
        if (mesh->left_out && mesh->left_out[p]) continue;
        if (mesh->has_glass[object] && vis_is_glass(graph, p) != (part == WALK_PANES)) continue;
        // Where two surfaces lie back to back, neither may hide the other: each is seen only from inside its own cell.
        if (part == WALK_SURFACES && !faces(graph, polygon, eye)) continue;
        memcpy(mesh->list + at, triangles, (size_t)count * sizeof *mesh->list);
        at += count;
    }
    return at;
}

// Puts the objects of a part in the order in which they are drawn; returns how many.
static int order_part(WalkMesh *mesh, int part, Vec3 eye, const int *objects, int count) {
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
    if (chosen > 1) qsort(mesh->order, (size_t)chosen, sizeof *mesh->order, by_distance);
    return chosen;
}

static int count_indices(const CellGraph *graph, const int *objects, int count) {
    int indices = 0;
    for (int i = 0; i < count; i++) {
        const Object *o = &graph->objects[objects[i]];
        for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++)
            indices += 3 * (graph->polygons[p].vertex_count - 2);
    }
    return indices;
}

static void fit_lists(WalkMesh *mesh, const int *objects, int count) {
    int indices = count_indices(mesh->graph, objects, count);
    if (count <= mesh->order_capacity && indices <= mesh->list_capacity) return;
    mesh->order = arena_room(&mesh->lists, mesh->order, sizeof *mesh->order, 0, count, &mesh->order_capacity);
    mesh->list = arena_room(&mesh->lists, mesh->list, sizeof *mesh->list, 0, indices, &mesh->list_capacity);
}

static void hold_chosen(WalkMesh *mesh, int count) {
    mesh->chosen =
        arena_room(&mesh->lists, mesh->chosen, sizeof *mesh->chosen, 0, count, &mesh->chosen_capacity);
    for (int i = 0; i < count; i++) mesh->chosen[i] = mesh->order[i].object;
    walk_store_hold(mesh->store, mesh->chosen, count);
}

void walk_mesh_list(WalkMesh *mesh, Vec3 eye, const int *objects, int count, const unsigned char *left_out,
                    bool panes_alone) {
    int at = 0;
    mesh->left_out = left_out;
    mesh->panes_alone = panes_alone;
    fit_lists(mesh, objects, count);
    if (!panes_alone) walk_store_hold(mesh->store, objects, count);
    for (int part = 0; part < WALK_PARTS; part++) {
        int chosen = panes_alone && part != WALK_PANES ? 0 : order_part(mesh, part, eye, objects, count);
        if (panes_alone && part == WALK_PANES) hold_chosen(mesh, chosen);
        for (int run = 0; run < WALK_RUNS; run++) {
            for (int i = 0; i < chosen && run < walk_textures_runs(mesh->textures); i++)
                at = add_object(mesh, mesh->order[i].object, part, run, eye, at);
            mesh->end[part * WALK_RUNS + run] = at;
        }
    }
    walk_store_bind(mesh->store);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, mesh->list_buffer);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)((size_t)at * sizeof *mesh->list), mesh->list,
                 GL_STREAM_DRAW);
}

void walk_mesh_bind(const WalkMesh *mesh) {
    walk_store_bind(mesh->store);
    glActiveTexture(GL_TEXTURE0 + WALK_UNIT_LAMPS);
    glBindTexture(GL_TEXTURE_BUFFER, mesh->lamp_texture);
    walk_store_bind_texels(mesh->store);
}

void walk_mesh_draw(const WalkMesh *mesh, int part, int run) {
    int from = part * WALK_RUNS + (run == WALK_ALL_RUNS ? 0 : run),
        to = run == WALK_ALL_RUNS ? from + WALK_RUNS - 1 : from;
    int first = from > 0 ? mesh->end[from - 1] : 0, count = mesh->end[to] - first;
    if (count == 0) return;
    walk_store_bind(mesh->store);
    glDrawElements(GL_TRIANGLES, count, GL_UNSIGNED_INT, (const void *)((size_t)first * sizeof *mesh->list));
}

// ---- points drawn once, by shaders that take nothing but their places

static float (*once_room(WalkMesh *mesh, int count))[3] {
    mesh->once = arena_room(&mesh->lists, mesh->once, sizeof *mesh->once, 0, count, &mesh->once_capacity);
    return mesh->once;
}

static void draw_once(const WalkMesh *mesh, int count, unsigned primitive) {
    glBindVertexArray(mesh->once_array);
    glBindBuffer(GL_ARRAY_BUFFER, mesh->once_buffer);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)((size_t)count * sizeof *mesh->once), mesh->once,
                 GL_STREAM_DRAW);
    glDrawArrays(primitive, 0, count);
}

static void put_corner(const WalkMesh *mesh, int leaf, int vertex, float out[3]) {
    Vec3 v = vec3_sub(walk_store_corner(mesh->store, leaf, vertex), mesh->origin);
    out[0] = (float)v.x;
    out[1] = (float)v.y;
    out[2] = (float)v.z;
}

void walk_mesh_draw_polygons(WalkMesh *mesh, int leaf, const int *polygons, int count) {
    const CellGraph *graph = mesh->graph;
    Arena scratch = {0};
    int most = 0, at = 0;
    for (int i = 0; i < count; i++) most += 3 * (graph->polygons[polygons[i]].vertex_count - 2);
    float(*out)[3] = once_room(mesh, most);
    int *triangle = ARENA_ARRAY(&scratch, int, most + 1);
    for (int i = 0; i < count; i++) {
        const Polygon *p = &graph->polygons[polygons[i]];
        polygon_triangulate(graph->vertices + p->first_vertex, p->vertex_count, triangle);
        for (int k = 0; k < 3 * (p->vertex_count - 2); k++)
            put_corner(mesh, leaf, p->first_vertex + triangle[k], out[at++]);
    }
    arena_free(&scratch);
    draw_once(mesh, at, GL_TRIANGLES);
}

void walk_mesh_draw_edges(WalkMesh *mesh, const int *objects, int object_count) {
    const CellGraph *graph = mesh->graph;
    int at = 0;
    float(*out)[3] = once_room(mesh, EDGE_POINTS);
    for (int k = 0; k < object_count; k++) {
        const Object *o = &graph->objects[objects[k]];
        for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++) {
            const Polygon *polygon = &graph->polygons[p];
            for (int i = 0; i < polygon->vertex_count; i++) {
                put_corner(mesh, o->leaf, polygon->first_vertex + i, out[at++]);
                put_corner(mesh, o->leaf, polygon->first_vertex + (i + 1) % polygon->vertex_count, out[at++]);
                if (at == EDGE_POINTS) draw_once(mesh, at, GL_LINES), at = 0;
            }
        }
    }
    draw_once(mesh, at, GL_LINES);
}
