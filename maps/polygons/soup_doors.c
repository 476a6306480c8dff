// soup_doors.c - doors among polygons, told by name: models know no openings, but most name their doors.
//
// All polygons of an object that is called a door count, and those of other objects whose material is called so. Polygons that
// hang together are one leaf, if their box stands upright and has the size of a door; it is taken as drawn closed, and hinged at one end.
#include "maps/polygons/soup_doors.h"

#include <ctype.h>
#include <stdlib.h>
#include <strings.h>

// Whole words, in any case; letters that ASCII lacks stand in both cases, in UTF-8.
static const char *const DOOR_WORDS[] = {"door",   "doors", "porte", "portes", "porta", "puerta", "puertas",
                                         "tür",    "tÜr",   "türen", "tÜren",  "tuer",  "tueren", "deur",
                                         "deuren", "dør",   "dØr",   "dörr",   "dÖrr",  NULL};
// Things that bear one of those words and do not turn.
static const char *const FIXED_WORDS[] = {"frame", "frames", "jamb",   "jambs", "casing", "lintel",
                                          "sill",  "mat",    "bell",   "step",  "zarge",  "rahmen",
                                          "cadre", "marco",  "kozijn", NULL};

// Sizes of the leaf of a door that a person passes, metres, from a garden gate to that of a barn.
static const double LEAST_WIDTH = 0.5, MOST_WIDTH = 6, LEAST_HEIGHT = 1.5, MOST_HEIGHT = 6;
// A leaf with its handles is no thicker than this, metres, and than this share of its width.
static const double MOST_THICKNESS = 0.4, MOST_SHARE = 0.5;
// A leaf is at least so thick, metres: it may be drawn as a single sheet.
static const double LEAST_THICKNESS = 0.01;
// Parts this near each other hang together, metres.
static const double TOGETHER = 0.02;
// The upright share of a normal above which a polygon is no side of a leaf.
static const double FLAT = 0.1;

// ---- names

static bool is_letter(unsigned char c) { return isalpha(c) || c >= 0x80; }

static bool among(const char *word, size_t length, const char *const *list) {
    for (; *list; list++) {
        if (strlen(*list) == length && strncasecmp(*list, word, length) == 0) return true;
    }
    return false;
}

// Words end where letters do, and where a capital follows a small letter.
static bool has_word(const char *name, const char *const *list) {
    for (const char *c = name ? name : ""; *c;) {
        while (*c && !is_letter((unsigned char)*c)) c++;
        const char *word = c;
        while (is_letter((unsigned char)*c)) {
            bool small = islower((unsigned char)*c);
            c++;
            if (small && isupper((unsigned char)*c)) break;
        }
        if (c > word && among(word, (size_t)(c - word), list)) return true;
    }
    return false;
}

static bool called_door(const char *name) {
    return has_word(name, DOOR_WORDS) && !has_word(name, FIXED_WORDS);
}

// ---- polygons that hang together

typedef struct Part {
    int polygon, leader;  // of parts that hang together the first of them leads
    int place;            // among all by their left ends
    Box box;
} Part;

static int by_left(const void *p, const void *q) {
    const Part *a = p, *b = q;
    if (a->box.min.x != b->box.min.x) return a->box.min.x < b->box.min.x ? -1 : 1;
    return a->polygon - b->polygon;
}

static int leader_of(Part *parts, int i) {
    while (parts[i].leader != i) i = parts[i].leader = parts[parts[i].leader].leader;
    return i;
}

// Thousands of polygons about one place all touch each other: of an object more looks than this find no doors in it.
static const double MOST_LOOKS = 3e8;

static int by_leader(const void *p, const void *q) {
    const Part *a = p, *b = q;
    return a->leader != b->leader ? (a->leader > b->leader) - (a->leader < b->leader)
                                  : (a->place > b->place) - (a->place < b->place);
}

// Parts that hang together become a run, their leader first. Returns how many parts there are, 0 where they are too many to tell.
static int join_parts(Part *parts, int count) {
    qsort(parts, (size_t)count, sizeof *parts, by_left);
    for (int i = 0; i < count; i++) parts[i].leader = parts[i].place = i;
    double looks = 0;
    for (int i = 0; i < count; i++) {
        for (int k = i + 1; k < count && parts[k].box.min.x <= parts[i].box.max.x; k++) {
            if (looks++ > MOST_LOOKS) return 0;
            if (!box_overlap(parts[i].box, parts[k].box)) continue;
            int a = leader_of(parts, i), b = leader_of(parts, k);
            parts[a > b ? a : b].leader = a > b ? b : a;
        }
    }
    for (int i = 0; i < count; i++) parts[i].leader = leader_of(parts, i);
    qsort(parts, (size_t)count, sizeof *parts, by_leader);
    return count;
}

static Box box_of_polygon(const Building *b, const Polygon *polygon) {
    Box box = box_empty();
    for (int i = 0; i < polygon->vertex_count; i++)
        box = box_add(box, b->vertices[polygon->first_vertex + i]);
    return box;
}

// ---- which of them are leaves

// The direction across the leaf: of its largest upright polygon.
static bool find_across(const Building *b, const Part *parts, int count, Vec2 *out) {
    double largest = 0;
    for (int i = 0; i < count; i++) {
        const Polygon *p = &b->polygons[parts[i].polygon];
        Vec3 n = plane_of_polygon(b->vertices + p->first_vertex, p->vertex_count).n;
        double area = polygon_area(b->vertices + p->first_vertex, p->vertex_count);
        if (fabs(n.z) > FLAT || area <= largest) continue;
        largest = area;
        *out = vec2_scale(vec2(n.x, n.y), 1 / hypot(n.x, n.y));
    }
    return largest > 0;
}

// The leaf of a door, or false.
static bool make_leaf(const Building *b, const Part *parts, int count, Leaf *out) {
    Vec2 across = {0, 0};
    if (!find_across(b, parts, count, &across)) return false;
    Vec2 along = {-across.y, across.x};
    Box box = box_empty();
    for (int i = 0; i < count; i++) {
        const Polygon *p = &b->polygons[parts[i].polygon];
        for (int k = 0; k < p->vertex_count; k++) {
            Vec3 v = b->vertices[p->first_vertex + k];
            Vec2 at = {v.x, v.y};
            box = box_add(box, vec3(vec2_dot(along, at), vec2_dot(across, at), v.z));
        }
    }
    Vec3 size = vec3_sub(box.max, box.min);
    if (size.x < LEAST_WIDTH || size.x > MOST_WIDTH || size.z < LEAST_HEIGHT || size.z > MOST_HEIGHT)
        return false;
    if (size.y > MOST_THICKNESS || size.y > MOST_SHARE * size.x) return false;
    Vec2 middle = vec2_scale(across, (box.min.y + box.max.y) / 2);
    Vec2 hinge = vec2_add(middle, vec2_scale(along, box.min.x));
    *out = (Leaf){.pivot = hinge,
                  .turn = M_PI / 2,
                  .axis = {hinge, vec2_add(middle, vec2_scale(along, box.max.x))},
                  .thickness = fmax(size.y, LEAST_THICKNESS),
                  .z0 = box.min.z,
                  .z1 = box.max.z};
    return true;
}

static bool all_glass(const Building *b, const Part *parts, int count) {
    for (int i = 0; i < count; i++) {
        if (b->materials[b->polygons[parts[i].polygon].material].alpha >= 1) return false;
    }
    return true;
}

static int add_opening(Arena *arena, Building *b, const char *name, Leaf leaf, bool glazed, int material) {
    leaf.opening = b->opening_count;
    Opening *o = ARENA_PUSH(arena, b->openings, b->opening_count, b->opening_capacity);
    *o = (Opening){.kind = OPENING_DOOR,
                   .name = name,
                   .storey = -1,
                   .glazed = glazed,
                   .line = {leaf.axis[0], leaf.axis[1]},
                   .sill = leaf.z0,
                   .head = leaf.z1,
                   .first_leaf = b->leaf_count,
                   .leaf_count = 1,
                   .region = {-1, -1},
                   .material = material};
    *ARENA_PUSH(arena, b->leaves, b->leaf_count, b->leaf_capacity) = leaf;
    return b->leaf_count - 1;
}

// ---- objects

// The new objects, and their polygons in the new order.
typedef struct Remade {
    Object *objects;
    Polygon *polygons;
    int object_count, object_capacity, polygon_count;
} Remade;

static void add_run(Remade *r, const Building *b, const Part *parts, int count) {
    for (int i = 0; i < count; i++) {
        r->polygons[r->polygon_count++] = b->polygons[parts[i].polygon];
    }
    Object *object = &r->objects[r->object_count - 1];
    object->polygon_count = r->polygon_count - object->first_polygon;
}

// Lists the polygons of an object that belong to doors, sorted so that those which hang together are neighbours. Returns their count.
static int list_parts(const Building *b, const Object *object, Part *out) {
    bool all = called_door(object->name);
    int count = 0;
    for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++) {
        bool named =
            called_door(b->materials[b->polygons[p].material].name) && !has_word(object->name, FIXED_WORDS);
        if (all || named)
            out[count++] = (Part){p, 0, 0, box_grow(box_of_polygon(b, &b->polygons[p]), TOGETHER / 2)};
    }
    return join_parts(out, count);
}

static void add_leaf_object(Arena *arena, Building *b, Remade *r, const Object *from, const Part *parts,
                            int count, const Leaf *leaf) {
    int material = b->polygons[parts[0].polygon].material;
    int index = add_opening(arena, b, from->name, *leaf, all_glass(b, parts, count), material);
    Object *object = ARENA_PUSH(arena, r->objects, r->object_count, r->object_capacity);
    *object = *from;
    object->kind = OBJECT_LEAF;
    object->first_polygon = r->polygon_count;
    object->opening = b->leaves[index].opening;
    object->leaf = index;
    add_run(r, b, parts, count);
}

// An object without the leaves in it, then these.
static void remake(Arena *arena, Building *b, const Object *from, Part *parts, unsigned char *taken,
                   Remade *r) {
    int count = list_parts(b, from, parts), first = r->object_count;
    *ARENA_PUSH(arena, r->objects, r->object_count, r->object_capacity) = *from;
    r->objects[first].first_polygon = -1;
    for (int i = 0, end; i < count; i = end) {
        for (end = i + 1; end < count && parts[end].leader == parts[i].leader;) end++;
        Leaf leaf;
        if (!make_leaf(b, parts + i, end - i, &leaf)) continue;
        for (int k = i; k < end; k++) taken[parts[k].polygon] = 1;
        add_leaf_object(arena, b, r, from, parts + i, end - i, &leaf);
    }
    r->objects[first].first_polygon = r->polygon_count;
    for (int p = from->first_polygon; p < from->first_polygon + from->polygon_count; p++) {
        if (!taken[p]) r->polygons[r->polygon_count++] = b->polygons[p];
    }
    r->objects[first].polygon_count = r->polygon_count - r->objects[first].first_polygon;
}

void soup_find_doors(Arena *arena, Building *b) {
    Arena scratch = {0};
    Part *parts = ARENA_ARRAY(&scratch, Part, b->polygon_count);
    unsigned char *taken = ARENA_ARRAY(&scratch, unsigned char, b->polygon_count);
    int *moved = ARENA_ARRAY(&scratch, int, b->object_count);
    Remade r = {.polygons = ARENA_ARRAY(arena, Polygon, b->polygon_count)};
    for (int i = 0; i < b->object_count; i++) {
        moved[i] = r.object_count;
        remake(arena, b, &b->objects[i], parts, taken, &r);
    }
    for (int i = 0; i < b->light_count; i++) {
        if (b->lights[i].object >= 0) b->lights[i].object = moved[b->lights[i].object];
    }
    b->objects = r.objects;
    b->object_count = r.object_count;
    b->object_capacity = r.object_capacity;
    b->polygons = r.polygons;
    b->polygon_capacity = b->polygon_count;
    arena_free(&scratch);
}
