// soup_split.c - large objects of a soup in parts that can be culled. Many exporters write a building as one mesh, and
// objects are drawn as wholes: without parts every cell would see all of it.
#include "maps/polygons/soup_split.h"

#include <stdlib.h>

#include "maps/polygons/soup_readers.h"

// Polygons that hang together over more than this share of the building are a shell: the walls around all rooms.
static const double SHELL = 0.25;

// A run of polygons that stay together.
typedef struct Clump {
    int first, count;  // in Splitter.order
    Vec3 middle;       // of its box
} Clump;

typedef struct Splitter {
    Arena *arena, *scratch;
    Building *b;
    const int *place;  // [vertex_count] the first vertex at the same place
    int *leader;       // [vertex_count] of the vertices of polygons that hang together
    int *order;        // [polygon_count] the polygons of an object, clump by clump
    Clump *clumps;
    int clump_count;
    double shell;  // metres
    Object *objects;
    Polygon *polygons;
    int object_count, object_capacity, polygon_count;
} Splitter;

static int leader_of(int *leader, int v) {
    while (leader[v] != v) v = leader[v] = leader[leader[v]];
    return v;
}

static int leader_of_polygon(const Splitter *s, int polygon) {
    return leader_of(s->leader, s->place[s->b->polygons[polygon].first_vertex]);
}

static Box box_of_polygon(const Building *b, int polygon, Box box) {
    const Polygon *p = &b->polygons[polygon];
    for (int k = 0; k < p->vertex_count; k++) box = box_add(box, b->vertices[p->first_vertex + k]);
    return box;
}

static double longest_side(Box box) {
    Vec3 size = vec3_sub(box.max, box.min);
    return fmax(size.x, fmax(size.y, size.z));
}

// The corners of each polygon of the object hang together: the lowest leads, so that nothing depends on their order.
static void hang_together(Splitter *s, const Object *object) {
    for (int i = object->first_polygon; i < object->first_polygon + object->polygon_count; i++) {
        const Polygon *p = &s->b->polygons[i];
        for (int k = 0; k < p->vertex_count; k++) {
            int v = s->place[p->first_vertex + k];
            s->leader[v] = v;
        }
    }
    for (int i = object->first_polygon; i < object->first_polygon + object->polygon_count; i++) {
        const Polygon *p = &s->b->polygons[i];
        for (int k = 1; k < p->vertex_count; k++) {
            int one = leader_of_polygon(s, i), other = leader_of(s->leader, s->place[p->first_vertex + k]);
            s->leader[one > other ? one : other] = one > other ? other : one;
        }
    }
}

typedef struct Led {
    int leader, polygon;
} Led;

static int by_leader(const void *p, const void *q) {
    const Led *a = p, *b = q;
    return a->leader != b->leader ? (a->leader > b->leader) - (a->leader < b->leader)
                                  : (a->polygon > b->polygon) - (a->polygon < b->polygon);
}

static void add_clump(Splitter *s, int first, int count, Box box) {
    s->clumps[s->clump_count++] = (Clump){first, count, vec3_scale(vec3_add(box.min, box.max), 0.5)};
}

// Adds `count` polygons that hang together, from `first` in the order on, as one clump; those of a shell one by one.
static void add_clumps(Splitter *s, int first, int count) {
    Box box = box_empty();
    for (int i = first; i < first + count; i++) box = box_of_polygon(s->b, s->order[i], box);
    if (longest_side(box) <= s->shell) {
        add_clump(s, first, count, box);
        return;
    }
    for (int i = first; i < first + count; i++)
        add_clump(s, i, 1, box_of_polygon(s->b, s->order[i], box_empty()));
}

static void list_clumps(Splitter *s, const Object *object) {
    int count = object->polygon_count;
    Led *led = ARENA_ARRAY(s->scratch, Led, count);
    hang_together(s, object);
    for (int i = 0; i < count; i++) {
        int polygon = object->first_polygon + i;
        led[i] = (Led){leader_of_polygon(s, polygon), polygon};
    }
    qsort(led, (size_t)count, sizeof *led, by_leader);
    for (int i = 0; i < count; i++) s->order[i] = led[i].polygon;
    s->clump_count = 0;
    for (int first = 0, end; first < count; first = end) {
        for (end = first + 1; end < count && led[end].leader == led[first].leader;) end++;
        add_clumps(s, first, end - first);
    }
}

static int by_number(const void *p, const void *q) {
    int a = *(const int *)p, b = *(const int *)q;
    return (a > b) - (a < b);
}

// An object of the clumps; its polygons in the order of the file.
static void add_part(Splitter *s, const Object *of, const Clump *clumps, int count, int polygons) {
    int *part = ARENA_ARRAY(s->scratch, int, polygons), used = 0;
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < clumps[i].count; k++) part[used++] = s->order[clumps[i].first + k];
    }
    qsort(part, (size_t)used, sizeof *part, by_number);
    Object *object = ARENA_PUSH(s->arena, s->objects, s->object_count, s->object_capacity);
    *object = *of;
    object->first_polygon = s->polygon_count;
    object->polygon_count = used;
    for (int i = 0; i < used; i++) s->polygons[s->polygon_count++] = s->b->polygons[part[i]];
}

static int compare_clumps_along(const Clump *a, const Clump *b, int axis) {
    double p = vec3_component(a->middle, axis), q = vec3_component(b->middle, axis);
    return p != q ? (p > q) - (p < q) : (a->first > b->first) - (a->first < b->first);
}

static int along_x(const void *p, const void *q) { return compare_clumps_along(p, q, 0); }
static int along_y(const void *p, const void *q) { return compare_clumps_along(p, q, 1); }
static int along_z(const void *p, const void *q) { return compare_clumps_along(p, q, 2); }

// Halves the set across the longest side of the box of its middles until it is small enough.
static void gather_clumps(Splitter *s, const Object *of, Clump *clumps, int count) {
    static int (*const ALONG[])(const void *, const void *) = {along_x, along_y, along_z};
    Box box = box_empty();
    int polygons = 0;
    for (int i = 0; i < count; i++) {
        box = box_add(box, clumps[i].middle);
        polygons += clumps[i].count;
    }
    if (count == 1 || polygons <= SOUP_PART_POLYGONS) {
        add_part(s, of, clumps, count, polygons);
        return;
    }
    Vec3 size = vec3_sub(box.max, box.min);
    int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    qsort(clumps, (size_t)count, sizeof *clumps, ALONG[axis]);
    gather_clumps(s, of, clumps, count / 2);
    gather_clumps(s, of, clumps + count / 2, count - count / 2);
}

static bool is_large(const Object *object) {
    return object->polygon_count > SOUP_PART_POLYGONS && object->kind != OBJECT_LAMP && object->leaf < 0;
}

static void split_object(Splitter *s, const Object *object) {
    if (is_large(object)) {
        list_clumps(s, object);
        gather_clumps(s, object, s->clumps, s->clump_count);
        return;
    }
    Object *kept = ARENA_PUSH(s->arena, s->objects, s->object_count, s->object_capacity);
    *kept = *object;
    kept->first_polygon = s->polygon_count;
    for (int i = 0; i < object->polygon_count; i++)
        s->polygons[s->polygon_count++] = s->b->polygons[object->first_polygon + i];
}

void soup_split(Arena *arena, Building *b) {
    bool any = false;
    for (int i = 0; i < b->object_count; i++) any |= is_large(&b->objects[i]);
    if (!any) return;
    Arena scratch = {0};
    Splitter s = {.arena = arena, .scratch = &scratch, .b = b, .shell = SHELL * longest_side(b->world)};
    s.place = soup_weld(b->vertices, b->vertex_count, &scratch);
    s.leader = ARENA_ARRAY(&scratch, int, b->vertex_count);
    s.order = ARENA_ARRAY(&scratch, int, b->polygon_count);
    s.clumps = ARENA_ARRAY(&scratch, Clump, b->polygon_count);
    s.polygons = ARENA_ARRAY(arena, Polygon, b->polygon_count);
    int *moved = ARENA_ARRAY(&scratch, int, b->object_count);
    for (int i = 0; i < b->object_count; i++) {
        moved[i] = s.object_count;
        split_object(&s, &b->objects[i]);
    }
    for (int i = 0; i < b->light_count; i++) {
        if (b->lights[i].object >= 0) b->lights[i].object = moved[b->lights[i].object];
    }
    b->objects = s.objects;
    b->object_count = s.object_count;
    b->object_capacity = s.object_capacity;
    b->polygons = s.polygons;
    b->polygon_capacity = b->polygon_count;
    arena_free(&scratch);
}
