// curved_scene.c - each shape at the tolerance that its nearest point needs.
#include "visibility/hidden/curved_scene.h"

#include <string.h>

#include "maps/curved/curved_tessellate.h"

// A shape nearer than this is subdivided as from there, metres: an eye may be within it.
static const double NEAREST = 0.05;

typedef struct Maker {
    CurvedScene *out;
    Polygon *polygons;
    Vec3 *vertices;
    int *shapes, *list;
    int polygon_count, vertex_count, list_count;
    int polygon_capacity, vertex_capacity, shape_capacity, list_capacity;
    Arena *arena;
} Maker;

// How near does a box come to the camera, along its view? False where the box is out of the picture.
static bool nearest_of(const Camera *camera, Box box, double *near) {
    double least = INFINITY, most = -INFINITY;
    bool out[4] = {true, true, true, true};
    for (int i = 0; i < 8; i++) {
        Vec3 corner =
            vec3(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y, i & 4 ? box.max.z : box.min.z);
        Vec3 to = vec3_sub(corner, camera->eye);
        double z = vec3_dot(to, camera->forward), x = vec3_dot(to, camera->right),
               y = vec3_dot(to, camera->up);
        least = fmin(least, z);
        most = fmax(most, z);
        out[0] &= x > z * camera->tan_x;
        out[1] &= x < -z * camera->tan_x;
        out[2] &= y > z * camera->tan_y;
        out[3] &= y < -z * camera->tan_y;
    }
    *near = fmax(least, NEAREST);
    return most > 0 && !out[0] && !out[1] && !out[2] && !out[3];
}

// The box of a shape's polygons, grown by the distance that they may lie inside of the shape.
static Box drawn_shape_box(const Building *b, const CurvedShape *shape) {
    Box box = box_empty();
    for (int i = shape->first_polygon; i < shape->first_polygon + shape->polygon_count; i++) {
        const Polygon *p = &b->polygons[i];
        for (int k = 0; k < p->vertex_count; k++) box = box_add(box, b->vertices[p->first_vertex + k]);
    }
    return box_grow(box, shape->tolerance);
}

static void add_mesh(Maker *m, const CurvedMesh *mesh, int shape, int material) {
    for (int i = 0; i < mesh->polygon_count; i++) {
        int first = mesh->first[i], count = mesh->first[i + 1] - first, shapes = m->polygon_count;
        Polygon polygon = {m->vertex_count, count, material, 0};
        *ARENA_PUSH(m->arena, m->shapes, shapes, m->shape_capacity) = shape;
        *ARENA_PUSH(m->arena, m->list, m->list_count, m->list_capacity) = m->polygon_count;
        *ARENA_PUSH(m->arena, m->polygons, m->polygon_count, m->polygon_capacity) = polygon;
        for (int k = 0; k < count; k++)
            *ARENA_PUSH(m->arena, m->vertices, m->vertex_count, m->vertex_capacity) =
                mesh->vertices[first + k];
    }
    m->out->subdivided += mesh->polygon_count;
}

// A shape's polygons come where the first of those they replace was in the list. False where none are made of it.
static bool subdivide(Maker *m, const Building *b, const CurvedShape *shape, const Camera *camera,
                      double pixels, double near) {
    double pixel = 2 * camera->tan_x / camera->width * near;
    Arena scratch = {0};
    CurvedMesh mesh;
    curved_tessellate(b, shape, pixels * pixel, &scratch, &mesh);
    bool made = mesh.polygon_count > 0;
    m->out->largest_off = fmax(m->out->largest_off, (made ? mesh.tolerance : shape->tolerance) / pixel);
    add_mesh(m, &mesh, (int)(shape - b->shapes), shape->material);
    arena_free(&scratch);
    return made;
}

static void copy_given(Maker *m, const Building *b, const Scene *given, int polygon_count, int vertex_count) {
    m->polygons = ARENA_ARRAY(m->arena, Polygon, polygon_count);
    m->vertices = ARENA_ARRAY(m->arena, Vec3, vertex_count);
    m->shapes = ARENA_ARRAY(m->arena, int, polygon_count);
    memcpy(m->polygons, given->polygons, sizeof(Polygon) * (size_t)polygon_count);
    memcpy(m->vertices, given->vertices, sizeof(Vec3) * (size_t)vertex_count);
    for (int i = 0; i < polygon_count; i++) m->shapes[i] = -1;
    for (int s = 0; s < b->shape_count; s++)
        for (int k = 0; k < b->shapes[s].polygon_count; k++) m->shapes[b->shapes[s].first_polygon + k] = s;
    m->polygon_count = m->polygon_capacity = m->shape_capacity = polygon_count;
    m->vertex_count = m->vertex_capacity = vertex_count;
}

void curved_scene_new(const Building *building, const Scene *given, int polygon_count, int vertex_count,
                      const Camera *camera, double pixels, Arena *arena, CurvedScene *out) {
    enum { UNSEEN, KEPT, DONE };
    *out = (CurvedScene){.first_polygon = polygon_count};
    Maker m = {.out = out, .arena = arena};
    copy_given(&m, building, given, polygon_count, vertex_count);
    unsigned char *state = ARENA_ARRAY(arena, unsigned char, building->shape_count + 1);
    for (int i = 0; i < given->count; i++) {
        int index = given->list ? given->list[i] : i, shape = m.shapes[index];
        double near;
        if (shape >= 0 && state[shape] == UNSEEN) {
            const CurvedShape *s = &building->shapes[shape];
            bool seen = nearest_of(camera, drawn_shape_box(building, s), &near);
            state[shape] = seen && subdivide(&m, building, s, camera, pixels, near) ? DONE : KEPT;
        }
        if (shape < 0 || state[shape] == KEPT)
            *ARENA_PUSH(arena, m.list, m.list_count, m.list_capacity) = index;
    }
    out->scene = (Scene){m.polygons, m.vertices, m.list, m.list_count};
    out->shape = m.shapes;
}
