// walk_store.c - two halves of one vertex buffer and of one texture, each filled from its start. Both looks share the vertices.
#include "engine/draw/walk_store.h"

#include <glad/gl.h>

#include "engine/core/polygon.h"
#include "engine/shade/walk_bake.h"

// All texels of a building that is held whole: 2 MiB as halves of a float, computed in a fifth of a second.
static const long TEXELS_WHOLE = 1 << 20;
// Objects made ahead leave this share of a half to those that frames need.
static const double LEFT_TO_FRAMES = 0.25;
// A half that is taken by this share may be left early, and what is moved to the other one takes up to this share of it.
static const double TURN_FROM = 0.65, TURN_UP_TO = 0.3;
// More objects than these are made by all threads side by side: else threads that wait for more work would slow down those of OpenGL.
enum { SIDE_BY_SIDE = 400 };

typedef struct WalkVertex {
    float position[3], normal[3];
    uint8_t colour[4], emission[4];  // for the fine look; colour: square root of the reflectance, alpha
    int32_t lamps[2];
    Rgba8 front, back;  // for the fast look, as seen from either side; of a surface in usual light
    float place[2];     // for surfaces: the place in the texture
} WalkVertex;

// An object that is held.
typedef struct Held {
    int object, first_vertex, first_index;  // in the half
    int first_square;                       // of a surface, in Half.squares: one for each polygon
    float share;                            // of a leaf: how far it is open as it was made
} Held;

// Where the texels of one polygon lie in the texture; `column` -1: there was no room, and usual light is shown, the texture's first row.
typedef struct Square {
    WalkTexels texels;
    int column, row;
    size_t made;  // where they are among the texels on their way to OpenGL
} Square;

// Texels of like height stand side by side on a shelf, which reaches across the texture. Of each height one shelf at most is open.
typedef struct Shelf {
    int height, row, column;
} Shelf;

typedef struct Layout {
    Shelf shelves[32];
    int shelf_count, row;  // the rows from `row` on are free
} Layout;

typedef struct Half {
    Held *held;
    Square *squares;
    unsigned *index;
    int held_count, held_capacity, square_count, square_capacity, index_count, index_capacity, vertex_count;
    Layout layout;
    Arena arena;
} Half;

struct WalkStore {
    const CellGraph *graph;
    const WalkTextures *textures;
    const WalkLights *lights;
    WalkBake *bake;
    Vec3 origin;
    Half halves[2];
    int half_count, current;  // 1: held whole
    int half_vertices, half_rows, most_rows;
    double coarseness;
    int refused;    // objects in the half being filled when it was not left early, or -1
    int *place;     // [object_count] 2 * the index in Half.held + the half; -1: not held
    float *share;   // [leaf_count] as posed
    Arena scratch;  // of one call
    WalkStoreFigures figures;
    unsigned array, vertex_buffer, picture_buffer, atlas;  // picture_buffer 0: nothing has a picture
};

WalkStoreLimits walk_store_usual_limits(void) { return (WalkStoreLimits){2 << 20, 1 << 17, 2048}; }
bool walk_store_whole(const WalkStore *store) { return store->half_count == 1; }
WalkStoreFigures walk_store_figures(const WalkStore *store) { return store->figures; }

static int object_vertices(const CellGraph *graph, int object) {
    const Object *o = &graph->objects[object];
    int count = 0;
    for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++)
        count += graph->polygons[p].vertex_count;
    return count;
}

static bool is_surface(const CellGraph *graph, int object) {
    return graph->objects[object].kind == OBJECT_SURFACE;
}

// The entry of an object that is held.
static Held *held_of(const WalkStore *store, int object) {
    int place = store->place[object];
    return &store->halves[place & 1].held[place >> 1];
}

// How far a leaf's object is open; of others 1.
static float leaf_share(const WalkStore *store, int object) {
    int leaf = store->graph->objects[object].leaf;
    return leaf < 0 ? 1 : store->share[leaf];
}

const unsigned *walk_store_triangles(const WalkStore *store, int object) {
    return store->halves[store->place[object] & 1].index + held_of(store, object)->first_index;
}

// ---- vertices

// Writes the vertices of a polygon whose corners are `v` at the moment. `square`: of a surface, else NULL.
static void fill_polygon(const WalkStore *store, int polygon, int object, const Square *square, const Vec3 *v,
                         WalkVertex *out) {
    const Polygon *p = &store->graph->polygons[polygon];
    const Material *m = &store->graph->building->materials[p->material];
    Vec3 n = plane_of_polygon(v, p->vertex_count).n;
    Rgb c = m->reflectance, glow = walk_glow(m);
    int lamp_count, first_lamp = walk_lamps_of(store->lights, object, &lamp_count);
    WalkVertex vertex = {
        .normal = {(float)n.x, (float)n.y, (float)n.z},
        .colour = {walk_byte(sqrtf(c.r)), walk_byte(sqrtf(c.g)), walk_byte(sqrtf(c.b)), walk_byte(m->alpha)},
        .emission = {walk_byte(glow.r), walk_byte(glow.g), walk_byte(glow.b),
                     walk_outdoors(store->graph, store->lights, object) ? 255 : 0},
        .lamps = {first_lamp, lamp_count}};
    double width = WALK_STORE_WIDTH, height = store->half_count * store->half_rows;
    for (int i = 0; i < p->vertex_count; i++) {
        Vec3 at = vec3_sub(v[i], store->origin);
        out[i] = vertex;
        out[i].position[0] = (float)at.x;
        out[i].position[1] = (float)at.y;
        out[i].position[2] = (float)at.z;
        if (square) {
            Vec2 in = vec2(0.5, 0.5);
            if (square->column >= 0)
                in = vec2_add(walk_bake_place(store->bake, &square->texels, v[i]),
                              vec2(square->column, square->row));
            out[i].place[0] = (float)(in.x / width);
            out[i].place[1] = (float)(in.y / height);
        }
        if (square && m->alpha == 1) {
            out[i].front = walk_bake_surface(store->bake, object, polygon);
        } else {
            out[i].front = walk_bake_point(store->bake, object, p->material, v[i], n);
            out[i].back = walk_bake_point(store->bake, object, p->material, v[i], vec3_scale(n, -1));
        }
    }
}

// ---- room in a half

// The height of the shelf for texels of this height: a few rows are lost, so that there are few heights.
static int shelf_height(int height) {
    int step = 4;
    for (int most = 32; height > most; most *= 2) step *= 2;
    return (height + step - 1) / step * step;
}

static Shelf *open_shelf(Layout *layout, int height) {
    for (int i = 0; i < layout->shelf_count; i++) {
        if (layout->shelves[i].height == height) return &layout->shelves[i];
    }
    CORE_ASSERT(layout->shelf_count < (int)(sizeof layout->shelves / sizeof *layout->shelves));
    layout->shelves[layout->shelf_count] = (Shelf){height, 0, WALK_STORE_WIDTH};
    return &layout->shelves[layout->shelf_count++];
}

// Finds a place for the texels of each square from `first` on. False where the half has too few rows.
static bool place_squares(const WalkStore *store, Half *half, int first) {
    Layout *layout = &half->layout;
    for (int i = first; i < half->square_count; i++) {
        Square *s = &half->squares[i];
        Shelf *shelf = open_shelf(layout, shelf_height(s->texels.height));
        if (shelf->column + s->texels.width > WALK_STORE_WIDTH) {
            s->column = -1;
            if (layout->row + shelf->height > store->half_rows) {
                if (store->coarseness < WALK_COARSENESS_MOST || store->half_rows < store->most_rows)
                    return false;
                continue;
            }
            shelf->column = 0;
            shelf->row = layout->row;
            layout->row += shelf->height;
        }
        s->column = shelf->column;
        s->row = (int)(half - store->halves) * store->half_rows + shelf->row;
        shelf->column += s->texels.width;
    }
    return true;
}

static void push_squares(const WalkStore *store, Half *half, int object) {
    const Object *o = &store->graph->objects[object];
    for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++) {
        Square square = {.texels = walk_bake_texels(store->bake, object, p, store->coarseness)};
        *ARENA_PUSH(&half->arena, half->squares, half->square_count, half->square_capacity) = square;
    }
}

static void push_triangles(const WalkStore *store, Half *half, const Held *held) {
    const CellGraph *graph = store->graph;
    const Object *o = &graph->objects[held->object];
    int vertex = store->halves == half ? 0 : store->half_vertices;
    vertex += held->first_vertex;
    for (int p = o->first_polygon; p < o->first_polygon + o->polygon_count; p++) {
        const Polygon *polygon = &graph->polygons[p];
        int count = 3 * (polygon->vertex_count - 2);
        half->index = arena_room(&half->arena, half->index, sizeof *half->index, half->index_count,
                                 half->index_count + count, &half->index_capacity);
        int *triangle = (int *)half->index + half->index_count;
        polygon_triangulate(graph->vertices + polygon->first_vertex, polygon->vertex_count, triangle);
        for (int k = 0; k < count; k++) triangle[k] += vertex;
        half->index_count += count;
        vertex += polygon->vertex_count;
    }
}

static void empty(WalkStore *store, Half *half) {
    int which = (int)(half - store->halves);
    for (int i = 0; i < half->held_count; i++) {
        int *place = &store->place[half->held[i].object];
        if (*place == 2 * i + which) *place = -1;  // else it is held in the other half by now
    }
    store->figures.vertices -= half->vertex_count;
    arena_free(&half->arena);
    *half = (Half){.layout = {.row = 1}};
}

typedef enum Lack { NOTHING, VERTICES, ROWS } Lack;

// Takes room in the half being filled for those of the objects that are not held anywhere. Takes nothing where it lacks something.
static Lack take_room(WalkStore *store, const int *objects, int count) {
    const CellGraph *graph = store->graph;
    Half *half = &store->halves[store->current], before = *half;
    Lack lack = NOTHING;
    for (int i = 0; i < count; i++) {
        int o = objects[i], vertices = object_vertices(graph, o);
        if (store->place[o] >= 0) continue;
        if (vertices > store->half_vertices - half->vertex_count) {
            lack = VERTICES;
            break;
        }
        Held held = {o, half->vertex_count, half->index_count, half->square_count, leaf_share(store, o)};
        store->place[o] = 2 * half->held_count + store->current;
        *ARENA_PUSH(&half->arena, half->held, half->held_count, half->held_capacity) = held;
        if (is_surface(graph, o)) push_squares(store, half, o);
        push_triangles(store, half, &held);
        half->vertex_count += vertices;
    }
    if (lack == NOTHING && !place_squares(store, half, before.square_count)) lack = ROWS;
    if (lack == NOTHING) return lack;
    for (int i = before.held_count; i < half->held_count; i++) store->place[half->held[i].object] = -1;
    half->held_count = before.held_count;
    half->square_count = before.square_count;
    half->index_count = before.index_count;
    half->vertex_count = before.vertex_count;
    half->layout = before.layout;
    return lack;
}

// ---- OpenGL's memory

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
    glVertexAttribIPointer(4, 2, GL_INT, stride, (const void *)offsetof(WalkVertex, lamps));
}

void walk_store_bind(const WalkStore *store) { glBindVertexArray(store->array); }

void walk_store_bind_texels(const WalkStore *store) {
    glActiveTexture(GL_TEXTURE0 + WALK_UNIT_ATLAS);
    glBindTexture(GL_TEXTURE_2D, store->atlas);
}

// Gives the buffers and the texture their present size; what they held is lost.
static void allocate_halves(WalkStore *store) {
    size_t vertices = (size_t)store->half_count * (size_t)store->half_vertices;
    int rows = store->half_count * store->half_rows;
    glBindVertexArray(store->array);
    glBindBuffer(GL_ARRAY_BUFFER, store->vertex_buffer);
    glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(vertices * sizeof(WalkVertex)), NULL, GL_STATIC_DRAW);
    describe_vertices();
    if (store->picture_buffer) {
        walk_textures_describe(store->picture_buffer);
        glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(vertices * sizeof(WalkPicture)), NULL, GL_STATIC_DRAW);
    }
    float usual[WALK_STORE_WIDTH];
    for (int i = 0; i < WALK_STORE_WIDTH; i++) usual[i] = 1;
    walk_store_bind_texels(store);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_R16F, WALK_STORE_WIDTH, rows, 0, GL_RED, GL_FLOAT, NULL);
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, WALK_STORE_WIDTH, 1, GL_RED, GL_FLOAT, usual);
}

static void grow(WalkStore *store, Lack lack) {
    for (int h = 0; h < store->half_count; h++) empty(store, &store->halves[h]);
    if (lack == VERTICES)
        store->half_vertices *= 2;
    else if (store->half_rows < store->most_rows)
        store->half_rows = 2 * store->half_rows < store->most_rows ? 2 * store->half_rows : store->most_rows;
    else
        store->coarseness *= WALK_COARSENESS_STEP;
    store->figures.grown++;
    allocate_halves(store);
}

// The vertices of some objects of a half on their way to OpenGL: vertex i is `first` + i of the half.
typedef struct Batch {
    int first;
    WalkVertex *vertex;
    WalkPicture *picture;  // NULL: nothing has a picture
    float *texels;         // those of a square side by side, row by row
} Batch;

// Makes the vertices of an object, and the texels.
static void make_object(const WalkStore *store, const Half *half, const Held *held, const Batch *batch) {
    const CellGraph *graph = store->graph;
    const Object *o = &graph->objects[held->object];
    Arena scratch = {0};
    int at = held->first_vertex - batch->first;
    Vec3 *corners = o->leaf >= 0 ? ARENA_ARRAY(&scratch, Vec3, object_vertices(graph, held->object)) : NULL;
    for (int i = 0; i < o->polygon_count; i++) {
        int polygon = o->first_polygon + i;
        const Polygon *p = &graph->polygons[polygon];
        const Vec3 *v = graph->vertices + p->first_vertex;
        const Square *square =
            is_surface(graph, held->object) ? &half->squares[held->first_square + i] : NULL;
        if (batch->picture)
            walk_textures_place(store->textures, p, v[0], v, p->vertex_count, batch->picture + at);
        for (int k = 0; k < p->vertex_count && corners; k++)
            corners[k] = leaf_point(&graph->building->leaves[o->leaf], (double)held->share, v[k]);
        fill_polygon(store, polygon, held->object, square, corners ? corners : v, batch->vertex + at);
        if (square && square->column >= 0)
            walk_bake_fill(store->bake, held->object, polygon, &square->texels, batch->texels + square->made,
                           (size_t)square->texels.width);
        at += p->vertex_count;
    }
    arena_free(&scratch);
}

static void upload_part(unsigned buffer, const void *from, size_t size, size_t first, size_t count) {
    glBindBuffer(GL_ARRAY_BUFFER, buffer);
    glBufferSubData(GL_ARRAY_BUFFER, (GLintptr)(first * size), (GLsizeiptr)(count * size), from);
}

static void upload_squares(const WalkStore *store, const Half *half, int first, const float *texels) {
    walk_store_bind_texels(store);
    glPixelStorei(GL_UNPACK_ALIGNMENT, sizeof *texels);
    for (int i = first; i < half->square_count; i++) {
        const Square *s = &half->squares[i];
        if (s->column >= 0)
            glTexSubImage2D(GL_TEXTURE_2D, 0, s->column, s->row, s->texels.width, s->texels.height, GL_RED,
                            GL_FLOAT, texels + s->made);
    }
}

// Gives each square from `first` on its part of an array of texels.
static float *room_for_texels(WalkStore *store, Half *half, int first) {
    size_t count = 0;
    for (int i = first; i < half->square_count; i++) {
        Square *s = &half->squares[i];
        s->made = count;
        count += (size_t)s->texels.width * (size_t)s->texels.height;
    }
    return ARENA_ARRAY(&store->scratch, float, count + 1);
}

// Makes and uploads `count` objects of a half, from the one numbered `from` on, and the texels of all squares from `square` on.
static void make_objects(WalkStore *store, int which, int from, int count, int square) {
    Half *half = &store->halves[which];
    if (count == 0) return;
    const Held *last = &half->held[from + count - 1];
    int first = half->held[from].first_vertex,
        end = last->first_vertex + object_vertices(store->graph, last->object);
    size_t vertices = (size_t)(end - first),
           place = (size_t)which * (size_t)store->half_vertices + (size_t)first;
    Batch batch = {first, ARENA_ARRAY(&store->scratch, WalkVertex, vertices + 1), NULL,
                   room_for_texels(store, half, square)};
    if (store->picture_buffer) batch.picture = ARENA_ARRAY(&store->scratch, WalkPicture, vertices + 1);
#pragma omp parallel for schedule(dynamic, 8) if (count > SIDE_BY_SIDE)
    for (int i = from; i < from + count; i++) make_object(store, half, &half->held[i], &batch);
    upload_part(store->vertex_buffer, batch.vertex, sizeof *batch.vertex, place, vertices);
    if (batch.picture)
        upload_part(store->picture_buffer, batch.picture, sizeof *batch.picture, place, vertices);
    upload_squares(store, half, square, batch.texels);
}

// Takes room for the objects in the half being filled and makes them.
static Lack take_objects(WalkStore *store, const int *objects, int count) {
    Half *half = &store->halves[store->current];
    int from = half->held_count, vertices = half->vertex_count, squares = half->square_count;
    Lack lack = take_room(store, objects, count);
    if (lack != NOTHING || half->held_count == from) return lack;
    make_objects(store, store->current, from, half->held_count - from, squares);
    store->figures.vertices += half->vertex_count - vertices;
    return NOTHING;
}

// ---- what is held

// The half that was filled before this one is emptied and filled from now on.
static void turn_over(WalkStore *store) {
    store->current = 1 - store->current;
    store->refused = -1;
    empty(store, &store->halves[store->current]);
    store->figures.emptied++;
}

// Leaves that have moved since they were made are made anew in their place.
static void move_leaves(WalkStore *store, const int *objects, int count) {
    for (int i = 0; i < count; i++) {
        if (store->graph->objects[objects[i]].leaf < 0) continue;
        Held *held = held_of(store, objects[i]);
        float share = leaf_share(store, objects[i]);
        if (held->share == share) continue;
        held->share = share;
        int place = store->place[objects[i]];
        make_objects(store, place & 1, place >> 1, 1, store->halves[place & 1].square_count);
    }
}

void walk_store_hold(WalkStore *store, const int *objects, int count) {
    bool turned = store->half_count == 1;
    arena_reset(&store->scratch);
    for (Lack lack; (lack = take_objects(store, objects, count)) != NOTHING; turned = true) {
        if (turned)
            grow(store, lack);
        else
            turn_over(store);
        arena_reset(&store->scratch);
    }
    move_leaves(store, objects, count);
}

// The points at which the light of an object is computed.
static int points_of(const WalkStore *store, int object) {
    const Object *o = &store->graph->objects[object];
    int points = object_vertices(store->graph, object);
    for (int p = o->first_polygon;
         p < o->first_polygon + o->polygon_count && is_surface(store->graph, object); p++) {
        WalkTexels texels = walk_bake_texels(store->bake, object, p, store->coarseness);
        points += texels.width * texels.height;
    }
    return points;
}

// The share of a half that is taken.
static double taken(const WalkStore *store, const Half *half) {
    return fmax((double)half->vertex_count / store->half_vertices,
                (double)half->layout.row / store->half_rows);
}

// Where all these objects lie in the half being filled, the other one is emptied early, before a frame has to wait for it: as long as they
// take so little room that they can be moved there while the person walks on.
static void turn_early(WalkStore *store, const int *objects, int count) {
    const Half *half = &store->halves[store->current];
    double vertices = 0, points = 0;
    if (taken(store, half) < TURN_FROM || half->held_count == store->refused) return;
    for (int i = 0; i < count; i++) {
        vertices += object_vertices(store->graph, objects[i]);
        points += points_of(store, objects[i]);
    }
    if (vertices < TURN_UP_TO * store->half_vertices &&
        points < TURN_UP_TO * store->half_rows * WALK_STORE_WIDTH)
        turn_over(store);
    else
        store->refused = half->held_count;
}

void walk_store_hold_ahead(WalkStore *store, const int *objects, int count, int most) {
    const Half *half = &store->halves[store->current];
    int chosen = 0, points = 0;
    if (store->half_count == 1) return;
    arena_reset(&store->scratch);
    int *next = ARENA_ARRAY(&store->scratch, int, count + 1),
        *before = ARENA_ARRAY(&store->scratch, int, count + 1);
    for (int i = 0; i < count && points < most; i++) {
        int place = store->place[objects[i]];
        if (place >= 0 && (place & 1) == store->current) continue;
        next[chosen] = objects[i];
        before[chosen++] = place;
        points += points_of(store, objects[i]);
    }
    if (chosen == 0) turn_early(store, objects, count);
    if (chosen == 0 || taken(store, half) > 1 - LEFT_TO_FRAMES) return;
    for (int i = 0; i < chosen; i++) store->place[next[i]] = -1;
    if (take_objects(store, next, chosen) == NOTHING) return;
    for (int i = 0; i < chosen; i++) store->place[next[i]] = before[i];
}

void walk_store_pose(WalkStore *store, const float *door_open) {
    const Building *b = store->graph->building;
    for (int i = 0; i < b->leaf_count; i++) store->share[i] = door_open ? door_open[b->leaves[i].opening] : 1;
}

Vec3 walk_store_corner(const WalkStore *store, int leaf, int vertex) {
    const CellGraph *graph = store->graph;
    Vec3 v = graph->vertices[vertex];
    return leaf < 0 ? v : leaf_point(&graph->building->leaves[leaf], (double)store->share[leaf], v);
}

// ---- interface

// A building of ordinary size: room for exactly that, and all of it made.
static void hold_whole(WalkStore *store, int vertices) {
    const CellGraph *graph = store->graph;
    Half *half = &store->halves[0];
    int *all = ARENA_ARRAY(&store->scratch, int, graph->object_count + 1);
    for (int o = 0; o < graph->object_count; o++) all[o] = o;
    store->half_count = 1;
    store->half_vertices = vertices;
    store->half_rows = store->most_rows;
    store->coarseness = walk_bake_coarseness(store->bake, TEXELS_WHOLE);
    while (take_room(store, all, graph->object_count) != NOTHING) store->coarseness *= WALK_COARSENESS_STEP;
    store->half_rows = half->layout.row;
    allocate_halves(store);
    make_objects(store, 0, 0, half->held_count, 0);
    store->figures.vertices = vertices;
}

WalkStore *walk_store_new(const CellGraph *graph, const WalkTextures *textures, const WalkLights *lights,
                          Vec3 origin, const WalkStoreLimits *limits, Arena *arena, Error *error) {
    WalkStore *store = ARENA_ARRAY(arena, WalkStore, 1);
    int most = 0;
    long vertices = 0;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &most);
    if (most < WALK_STORE_WIDTH) {
        error_set(error, "OpenGL has textures of %d texels each way (%d are needed)", most, WALK_STORE_WIDTH);
        return NULL;
    }
    for (int o = 0; o < graph->object_count; o++) vertices += object_vertices(graph, o);
    *store = (WalkStore){.graph = graph,
                         .textures = textures,
                         .lights = lights,
                         .bake = walk_bake_new(graph, lights, origin, arena),
                         .origin = origin,
                         .halves = {{.layout = {.row = 1}}, {.layout = {.row = 1}}},
                         .half_count = 2,
                         .half_vertices = limits->half_vertices,
                         .half_rows = limits->half_rows,
                         .most_rows = most / 2,
                         .coarseness = 1,
                         .refused = -1,
                         .place = ARENA_ARRAY(arena, int, graph->object_count + 1),
                         .share = ARENA_ARRAY(arena, float, graph->building->leaf_count + 1)};
    for (int o = 0; o < graph->object_count; o++) store->place[o] = -1;
    glGenVertexArrays(1, &store->array);
    glGenBuffers(1, &store->vertex_buffer);
    if (walk_textures_runs(textures) > 1) glGenBuffers(1, &store->picture_buffer);
    glGenTextures(1, &store->atlas);
    walk_store_bind_texels(store);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    walk_store_pose(store, NULL);
    if (vertices <= limits->whole_most)
        hold_whole(store, (int)vertices);
    else
        allocate_halves(store);
    return store;
}

void walk_store_free(WalkStore *store) {
    if (!store) return;
    unsigned buffers[] = {store->vertex_buffer, store->picture_buffer};
    glDeleteVertexArrays(1, &store->array);
    glDeleteBuffers(2, buffers);
    glDeleteTextures(1, &store->atlas);
    for (int h = 0; h < 2; h++) arena_free(&store->halves[h].arena);
    arena_free(&store->scratch);
}
