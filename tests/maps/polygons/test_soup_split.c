// test_soup_split.c - one mesh in parts: none lost, none torn apart, none spread over the building.
#include <criterion/criterion.h>

#include "engine/core/random.h"
#include "maps/polygons/soup_split.h"

enum { SIDE = 40, BOXES = 60, FACES = 6, LEAVES = 300 };

static void add_quad(Arena *arena, Building *b, Vec3 at, Vec3 u, Vec3 v) {
    Vec3 q[4] = {at, vec3_add(at, u), vec3_add(vec3_add(at, u), v), vec3_add(at, v)};
    building_add_polygon(arena, b, q, 4, 0);
}

static void add_box(Arena *arena, Building *b, Vec3 at, double side) {
    Vec3 x = {side, 0, 0}, y = {0, side, 0}, z = {0, 0, side}, far = vec3_add(at, vec3(side, side, side));
    add_quad(arena, b, at, y, x);
    add_quad(arena, b, at, x, z);
    add_quad(arena, b, at, z, y);
    for (int k = 0; k < 3; k++) {
        Vec3 back[3] = {vec3_scale(x, -1), vec3_scale(y, -1), vec3_scale(z, -1)};
        add_quad(arena, b, far, back[(k + 1) % 3], back[k]);
    }
}

// A floor of 1,600 squares that hang together, boxes on it, and a plant of 300 leaves on one stem: one object, its
// polygons in random order.
static Building *mesh(Arena *arena, Random *random) {
    Building *b = ARENA_ARRAY(arena, Building, 1);
    building_add_material(arena, b, (Material){.name = "m", .alpha = 1});
    building_add_object(arena, b, OBJECT_FURNITURE, "mesh");
    for (int i = 0; i < SIDE * SIDE; i++) {
        Vec3 at = {i % SIDE, i / SIDE, 0};
        add_quad(arena, b, at, vec3(1, 0, 0), vec3(0, 1, 0));
    }
    for (int i = 0; i < BOXES; i++)
        add_box(arena, b, vec3(random_between(random, 1, 38), random_between(random, 1, 38), 0.1), 0.5);
    for (int i = 0; i < LEAVES; i++) {
        double turn = 2 * M_PI * i / LEAVES;
        Vec3 stem = {5, 5, 1}, tip = {5 + cos(turn), 5 + sin(turn), 2};
        building_add_polygon(arena, b, (Vec3[]){stem, tip, vec3_add(tip, vec3(0, 0, 0.1))}, 3, 0);
    }
    for (int i = b->polygon_count - 1; i > 0; i--) {
        int k = random_index(random, i + 1);
        Polygon swapped = b->polygons[i];
        b->polygons[i] = b->polygons[k];
        b->polygons[k] = swapped;
    }
    b->world = box_empty();
    for (int i = 0; i < b->vertex_count; i++) b->world = box_add(b->world, b->vertices[i]);
    return b;
}

// The part that holds the polygon which begins at a vertex.
static int part_of(const Building *b, int vertex) {
    for (int o = 0; o < b->object_count; o++) {
        const Object *object = &b->objects[o];
        for (int i = 0; i < object->polygon_count; i++)
            if (b->polygons[object->first_polygon + i].first_vertex == vertex) return o;
    }
    return -1;
}

// Proves that parts hold all polygons once, that what hangs together stays so unless it is a shell, and that a part holds
// no more than it may unless it hangs together, and spans little of the building.
Test(soup_split, parts_one_mesh) {
    for (uint64_t seed = 1; seed <= 20; seed++) {
        Arena arena = {0};
        Random random = {seed};
        Building *b = mesh(&arena, &random);
        int polygons = b->polygon_count;
        soup_split(&arena, b);
        cr_assert_eq(b->polygon_count, polygons);
        unsigned char *seen = ARENA_ARRAY(&arena, unsigned char, b->vertex_count);
        int parts = 0;
        for (int o = 0; o < b->object_count; o++) {
            const Object *object = &b->objects[o];
            Box box = box_empty();
            cr_assert_eq(object->first_polygon, parts, "seed %d", (int)seed);
            parts += object->polygon_count;
            for (int i = object->first_polygon; i < parts; i++) {
                const Polygon *p = &b->polygons[i];
                cr_assert(!seen[p->first_vertex]++, "seed %d: polygon %d twice", (int)seed, i);
                for (int k = 0; k < p->vertex_count; k++)
                    box = box_add(box, b->vertices[p->first_vertex + k]);
            }
            Vec3 size = vec3_sub(box.max, box.min);
            cr_assert_str_eq(object->name, "mesh");
            cr_assert(object->polygon_count <= SOUP_PART_POLYGONS || object->polygon_count == LEAVES,
                      "seed %d: %d", (int)seed, object->polygon_count);
            // Eleven parts or so of 40 x 40 m: the halves of halves of a side are 10 m, boxes and the plant stand out.
            cr_assert_lt(fmin(size.x, size.y), 13, "seed %d: part %d spans %g x %g m", (int)seed, o, size.x,
                         size.y);
        }
        cr_assert_eq(parts, polygons);
        // Boxes and the plant: their vertices follow those of the floor.
        for (int i = 0; i < BOXES; i++) {
            int first = 4 * (SIDE * SIDE + FACES * i), part = part_of(b, first);
            for (int k = 1; k < FACES; k++)
                cr_assert_eq(part_of(b, first + 4 * k), part, "seed %d: box %d is torn", (int)seed, i);
        }
        int plant = 4 * (SIDE * SIDE + FACES * BOXES);
        for (int k = 1; k < LEAVES; k++)
            cr_assert_eq(part_of(b, plant + 3 * k), part_of(b, plant), "leaf %d", k);
        arena_free(&arena);
    }
}

// Small objects, leaves of doors and lamps stay as they are; lights find their lamps again.
Test(soup_split, leaves_what_must_stay) {
    Arena arena = {0};
    Random random = {7};
    Building *b = mesh(&arena, &random);
    int large = b->polygon_count;
    building_add_object(&arena, b, OBJECT_LAMP, "lamp");
    for (int i = 0; i < 50; i++) add_box(&arena, b, vec3(i, 0, 3), 0.5);
    building_add_object(&arena, b, OBJECT_LEAF, "door");
    for (int i = 0; i < 50; i++) add_box(&arena, b, vec3(i, 0, 5), 0.5);
    building_add_object(&arena, b, OBJECT_FURNITURE, "chair");
    add_box(&arena, b, vec3(1, 1, 1), 0.5);
    b->objects[2].leaf = 0;
    for (int o = 0; o < 4; o++) b->objects[o].opening = b->objects[o].leaf = o == 2 ? 0 : -1;
    b->lights = ARENA_ARRAY(&arena, Light, 2);
    b->lights[0].object = 1;
    b->lights[1].object = -1;
    b->light_count = 2;
    soup_split(&arena, b);
    int n = b->object_count;
    cr_assert_gt(n, 8);
    cr_assert_str_eq(b->objects[n - 3].name, "lamp");
    cr_assert_eq(b->objects[n - 3].first_polygon, large);
    cr_assert_eq(b->objects[n - 3].polygon_count, 300);
    cr_assert_str_eq(b->objects[n - 2].name, "door");
    cr_assert_eq(b->objects[n - 2].polygon_count, 300);
    cr_assert_str_eq(b->objects[n - 1].name, "chair");
    cr_assert_eq(b->lights[0].object, n - 3);
    cr_assert_eq(b->lights[1].object, -1);
    arena_free(&arena);
}
