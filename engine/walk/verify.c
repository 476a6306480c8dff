// verify.c - compares the culled frame with the unculled one, pixel for pixel.
#include "engine/walk/verify.h"

#include <string.h>

#include "engine/core/clock.h"
#include "engine/gl/gl_context.h"
#include "visibility/hidden/gl_items.h"

struct WalkVerify {
    const CellGraph *graph;
    VisQuery *query;
    GlContext *context;
    GlItems *items;
    Arena images;  // of the present frame size
    ItemBuffer culled, unculled, with_glass, in_mirror;
    int32_t *mirror_items[MIRRORS_SHOWN];
    Mirrors *mirrors;  // or NULL
    const MirrorView *views;
    int view_count;
    uint32_t *culled_colour, *unculled_colour;
    int *object_of;       // [polygon_count]
    int *list;            // [polygon_count] the items' list
    int *opaque, *glass;  // [object_count + 1] where each object's polygons begin in the items' list
    unsigned *drawn;      // [object_count] the last frame whose draw list had the object
    unsigned *counted;    // [polygon_count] the last count that the polygon was part of
    unsigned frame, count;
    const float *door_open;
    Vec3 *vertices;  // [vertex_count] with the leaves of doors where they stand
};

// A flat shade by material and direction: enough to tell surfaces apart, the same in every frame.
static uint32_t shade(const CellGraph *graph, int polygon) {
    const Polygon *p = &graph->polygons[polygon];
    const Material *m = &graph->building->materials[p->material];
    Vec3 n = plane_of_polygon(graph->vertices + p->first_vertex, p->vertex_count).n;
    double light = 0.70 + 0.12 * fabs(n.x) - 0.06 * fabs(n.y) + 0.18 * fabs(n.z);
    float channels[3] = {m->reflectance.r, m->reflectance.g, m->reflectance.b};
    float emission[3] = {m->emission.r, m->emission.g, m->emission.b};
    uint32_t colour = 0xff000000u;
    for (int c = 0; c < 3; c++) {
        double value = pow(fmin(channels[c] * light + emission[c], 1), 1 / 2.2);
        colour |= (uint32_t)lround(255 * value) << (8 * c);
    }
    return colour;
}

// The items' list: all opaque polygons in draw order, then all polygons of glass.
static bool make_items(WalkVerify *v, Arena *arena, Error *error) {
    const CellGraph *graph = v->graph;
    Arena scratch = {0};
    int *list = ARENA_ARRAY(arena, int, graph->polygon_count + 1), count = 0;
    uint32_t *colours = ARENA_ARRAY(&scratch, uint32_t, graph->polygon_count + 1);
    unsigned char *one_sided = ARENA_ARRAY(arena, unsigned char, graph->polygon_count + 1);
    for (int glass = 0; glass < 2; glass++) {
        int *first = glass ? v->glass : v->opaque;
        for (int o = 0; o < graph->object_count; o++) {
            first[o] = count;
            for (int i = 0; i < graph->objects[o].polygon_count; i++) {
                int polygon = graph->objects[o].first_polygon + i;
                v->object_of[polygon] = o;
                if (vis_is_glass(graph, polygon) != (glass == 1)) continue;
                colours[count] = shade(graph, polygon);
                one_sided[count] = graph->objects[o].kind == OBJECT_SURFACE;
                list[count++] = polygon;
            }
        }
        first[graph->object_count] = count;
    }
    v->list = list;
    v->vertices = ARENA_ARRAY(arena, Vec3, graph->vertex_count + 1);
    memcpy(v->vertices, graph->vertices, (size_t)graph->vertex_count * sizeof *v->vertices);
    Scene scene = {graph->polygons, v->vertices, list, count};
    v->items = gl_items_new(&scene, colours, one_sided, arena, error);
    arena_free(&scratch);
    return v->items != NULL;
}

WalkVerify *walk_verify_new(const CellGraph *graph, const StabForest *forest, Arena *arena, Error *error) {
    WalkVerify *v = ARENA_ARRAY(arena, WalkVerify, 1);
    v->graph = graph;
    v->query = vis_query_new(graph, forest, arena);
    v->mirrors = mirrors_new(graph, forest, arena);
    v->object_of = ARENA_ARRAY(arena, int, graph->polygon_count + 1);
    v->opaque = ARENA_ARRAY(arena, int, graph->object_count + 1);
    v->glass = ARENA_ARRAY(arena, int, graph->object_count + 1);
    v->drawn = ARENA_ARRAY(arena, unsigned, graph->object_count + 1);
    v->counted = ARENA_ARRAY(arena, unsigned, graph->polygon_count + 1);
    v->context = gl_context_open(arena, error);
    if (!v->context) return NULL;
    if (make_items(v, arena, error)) return v;
    gl_context_close(v->context);
    return NULL;
}

void walk_verify_free(WalkVerify *v) {
    if (!v) return;
    if (gl_context_use(v->context, NULL)) gl_items_free(v->items);
    gl_context_close(v->context);
    mirrors_free(v->mirrors);
    arena_free(&v->images);
}

static void make_images(WalkVerify *v, int width, int height) {
    if (v->culled.width == width && v->culled.height == height) return;
    arena_reset(&v->images);
    size_t pixels = (size_t)width * (size_t)height;
    v->culled = item_buffer_new(&v->images, width, height);
    v->unculled = item_buffer_new(&v->images, width, height);
    v->with_glass = item_buffer_new(&v->images, width, height);
    v->in_mirror = item_buffer_new(&v->images, width, height);
    for (int i = 0; i < MIRRORS_SHOWN; i++) v->mirror_items[i] = ARENA_ARRAY(&v->images, int32_t, pixels);
    v->culled_colour = ARENA_ARRAY(&v->images, uint32_t, pixels);
    v->unculled_colour = ARENA_ARRAY(&v->images, uint32_t, pixels);
}

// Adds the polygons of an object from `first` to `end` of the items' list, but for those in whose plane the eye is.
static void add_before(WalkVerify *v, int first, int end, Vec3 eye) {
    for (int i = first; i < end; i++) {
        const Polygon *polygon = &v->graph->polygons[v->list[i]];
        Plane plane = plane_of_polygon(v->vertices + polygon->first_vertex, polygon->vertex_count);
        if (fabs(plane_distance(plane, eye)) >= VERIFY_IN_SURFACE) gl_items_add(v->items, i, 1);
    }
}

// With an eye, polygons that it is in are left out.
static bool draw_objects(WalkVerify *v, const int *first, bool all, const Vec3 *eye, Error *error) {
    for (int o = 0; o < v->graph->object_count; o++) {
        bool draw = all ? vis_shown(&v->graph->objects[o], v->door_open) : v->drawn[o] == v->frame;
        if (!draw) continue;
        if (eye && box_contains(box_grow(v->graph->object_boxes[o], VERIFY_IN_SURFACE), *eye)) {
            add_before(v, first[o], first[o + 1], *eye);
        } else {
            gl_items_add(v->items, first[o], first[o + 1] - first[o]);
        }
    }
    return gl_items_draw(v->items, error);
}

int walk_verify_missing(WalkVerify *v, const ItemBuffer *items, int *missing) {
    v->count++;
    int count = 0;
    for (int p = 0; p < items->width * items->height; p++) {
        int polygon = items->item[p];
        if (polygon < 0 || v->counted[polygon] == v->count) continue;
        v->counted[polygon] = v->count;
        if (v->drawn[v->object_of[polygon]] == v->frame) continue;
        if (missing) *missing = polygon;
        count++;
    }
    return count;
}

// The draw list of the frame or mirror under way.
static void mark_drawn(WalkVerify *v, const int *objects, int count) {
    v->frame++;
    for (int i = 0; i < count; i++) v->drawn[objects[i]] = v->frame;
}

static void pose(WalkVerify *v) {
    vis_pose(v->graph, v->door_open, v->vertices);
    for (int o = 0; o < v->graph->building->object_count; o++) {
        if (v->graph->objects[o].leaf < 0) continue;
        gl_items_moved(v->items, v->opaque[o], v->opaque[o + 1] - v->opaque[o]);
        gl_items_moved(v->items, v->glass[o], v->glass[o + 1] - v->glass[o]);
    }
}

static int count_mismatches(const ItemBuffer *a, const ItemBuffer *b, const uint32_t *ca,
                            const uint32_t *cb) {
    int count = 0;
    for (int p = 0; p < a->width * a->height; p++) {
        count += a->item[p] != b->item[p] || (ca && ca[p] != cb[p]);
    }
    return count;
}

// Draws both frames once more with glass on top, and adds the polygons missing there.
static bool compare_glass(WalkVerify *v, const Camera *camera, VerifyFrame *out, Error *error) {
    if (!draw_objects(v, v->glass, true, NULL, error) ||
        !gl_items_read(v->items, &v->with_glass, v->unculled_colour, error)) {
        return false;
    }
    out->missing_polygons += walk_verify_missing(v, &v->with_glass, &out->missing);
    double start = clock_seconds();
    if (!gl_items_look(v->items, camera, NULL, error) || !draw_objects(v, v->opaque, false, NULL, error))
        return false;
    if (!gl_items_read(v->items, &v->culled, NULL, error)) return false;
    out->mismatched_pixels += count_mismatches(&v->culled, &v->unculled, NULL, NULL);
    if (!draw_objects(v, v->glass, false, NULL, error) ||
        !gl_items_read(v->items, &v->culled, v->culled_colour, error)) {
        return false;
    }
    out->draw_seconds = clock_seconds() - start;
    out->mismatched_pixels +=
        count_mismatches(&v->culled, &v->with_glass, v->culled_colour, v->unculled_colour);
    return true;
}

// Draws what is seen in a mirror, with or without culling, and with glass as if it were opaque, if wanted.
static bool draw_mirror(WalkVerify *v, const MirrorView *view, bool all, bool glass, ItemBuffer *out,
                        Error *error) {
    const Vec3 *eye = &view->camera.eye;
    return gl_items_look(v->items, &view->camera, &view->before, error) &&
           draw_objects(v, v->opaque, all, eye, error) &&
           (!glass || draw_objects(v, v->glass, all, eye, error)) &&
           gl_items_read(v->items, out, NULL, error);
}

// Does the frame show one of the polygons counted last at pixel (x, y) and all around it? At a border a rasteriser, which rounds corners
// to a 256th of a pixel, may see the mirror where a ray passes beside it.
static bool shows_counted(const WalkVerify *v, int x, int y) {
    const ItemBuffer *b = &v->unculled;
    for (int j = y - 1; j <= y + 1; j++) {
        for (int i = x - 1; i <= x + 1; i++) {
            if (i < 0 || j < 0 || i >= b->width || j >= b->height) return false;
            int polygon = b->item[j * b->width + i];
            if (polygon < 0 || v->counted[polygon] != v->count) return false;
        }
    }
    return true;
}

// Keeps the items at the pixels where the frame shows the mirror.
static void keep_mirror(WalkVerify *v, const MirrorView *view, const ItemBuffer *seen, int32_t *kept) {
    v->count++;
    for (int i = 0; i < view->polygon_count; i++) v->counted[view->polygons[i]] = v->count;
    for (int y = 0; y < seen->height; y++) {
        for (int x = 0; x < seen->width; x++) {
            int at = y * seen->width + x;
            kept[at] = shows_counted(v, x, y) ? seen->item[at] : -1;
        }
    }
}

// Compares what is seen in a mirror culled with what is seen there unculled. Keeps the opaque polygons of the latter.
static bool compare_mirror(WalkVerify *v, int index, VerifyFrame *out, Error *error) {
    const MirrorView *view = &v->views[index];
    int pixels = view->camera.width * view->camera.height;
    ItemBuffer kept = {view->camera.width, view->camera.height, v->mirror_items[index], NULL};
    mark_drawn(v, view->objects, view->object_count);
    for (int glass = 1; glass >= 0; glass--) {
        if (!draw_mirror(v, view, true, glass, &v->in_mirror, error)) return false;
        keep_mirror(v, view, &v->in_mirror, kept.item);
        out->missing_polygons += walk_verify_missing(v, &kept, &out->missing);
        if (!draw_mirror(v, view, false, glass, &v->in_mirror, error)) return false;
        keep_mirror(v, view, &v->in_mirror, v->culled.item);
        out->mismatched_pixels += count_mismatches(&kept, &v->culled, NULL, NULL);
    }
    out->mirrors++;
    for (int p = 0; p < pixels; p++) out->mirror_pixels += kept.item[p] >= 0;
    return true;
}

bool walk_verify_frame(WalkVerify *v, const Camera *camera, int cell, const float *door_open, Culling culling,
                       VerifyFrame *out, Error *error) {
    *out = (VerifyFrame){.missing = -1};
    if (!gl_context_use(v->context, error)) return false;
    make_images(v, camera->width, camera->height);
    v->door_open = door_open;
    pose(v);
    Eye eye = walk_eye(camera);
    double start = clock_seconds();
    out->visible = vis_query(v->query, &eye, cell, door_open, culling);
    out->query_seconds = clock_seconds() - start;
    mark_drawn(v, out->visible.objects, out->visible.object_count);
    if (!gl_items_look(v->items, camera, NULL, error) || !draw_objects(v, v->opaque, true, NULL, error) ||
        !gl_items_read(v->items, &v->unculled, NULL, error)) {
        return false;
    }
    out->missing_polygons = walk_verify_missing(v, &v->unculled, &out->missing);
    v->view_count = mirrors_look(v->mirrors, camera, &out->visible, door_open, culling, &v->views);
    if (!compare_glass(v, camera, out, error)) return false;
    for (int i = 0; i < v->view_count; i++) {
        if (!compare_mirror(v, i, out, error)) return false;
    }
    mark_drawn(v, out->visible.objects, out->visible.object_count);
    return true;
}

int walk_verify_mirrors(const WalkVerify *v, const MirrorView **views) {
    *views = v->views;
    return v->view_count;
}

const int32_t *walk_verify_mirror_items(const WalkVerify *v, int mirror) { return v->mirror_items[mirror]; }

void walk_verify_image(const WalkVerify *v, uint8_t *rgb) {
    for (int p = 0; p < v->culled.width * v->culled.height; p++) {
        for (int c = 0; c < 3; c++) rgb[3 * p + c] = (uint8_t)(v->culled_colour[p] >> (8 * c));
    }
}

const ItemBuffer *walk_verify_items(const WalkVerify *v) { return &v->with_glass; }

const Vec3 *walk_verify_vertices(const WalkVerify *v) { return v->vertices; }

static bool faces_away(const CellGraph *graph, int polygon, Vec3 eye) {
    const Polygon *p = &graph->polygons[polygon];
    const Vec3 *v = graph->vertices + p->first_vertex;
    return vec3_dot(plane_of_polygon(v, p->vertex_count).n, vec3_sub(eye, v[0])) <= 0;
}

int walk_opaque_polygons(const CellGraph *graph, const float *door_open, const Vec3 *eye, int *list) {
    int count = 0;
    for (int o = 0; o < graph->object_count; o++) {
        const Object *object = &graph->objects[o];
        if (!vis_shown(object, door_open)) continue;
        for (int i = 0; i < object->polygon_count; i++) {
            int polygon = object->first_polygon + i;
            bool hidden = eye && object->kind == OBJECT_SURFACE && faces_away(graph, polygon, *eye);
            if (!hidden && !vis_is_glass(graph, polygon)) list[count++] = polygon;
        }
    }
    return count;
}
