// reconstruct_fixture.c - see the header.
#include "tests/radiosity/show/reconstruct_fixture.h"

#include <criterion/criterion.h>

#include "engine/core/polygon.h"
#include "radiosity/show/reconstruct.h"
#include "tests/support/lit_fixture.h"

void reconstruct_hand_start(Hand *hand) {
    *hand = (Hand){.objects = {{.kind = OBJECT_FURNITURE}, {.kind = OBJECT_SURFACE}}};
    hand->graph.objects = hand->objects;
    hand->mesh.graph = &hand->graph;
}

static int hand_vertex(Hand *hand, Vec3 p) {
    Mesh *mesh = &hand->mesh;
    for (int i = 0; i < mesh->vertex_count; i++)
        if (vec3_length(vec3_sub(mesh->vertices[i], p)) < 1e-9) return i;
    *ARENA_PUSH(&hand->arena, mesh->vertices, mesh->vertex_count, hand->vertex_capacity) = p;
    return mesh->vertex_count - 1;
}

void reconstruct_hand_add(Hand *hand, const Vec3 *v, int count, int material, int object) {
    Mesh *mesh = &hand->mesh;
    int f = mesh->face_count;
    *ARENA_PUSH(&hand->arena, mesh->faces, mesh->face_count, hand->face_capacity) =
        (Face){.object = object,
               .material = material,
               .plane = plane_of_polygon(v, count),
               .first_element = f,
               .element_count = 1};
    *ARENA_PUSH(&hand->arena, mesh->elements, mesh->element_count, hand->element_capacity) = (Element){
        .face = f, .first_corner = mesh->corner_count, .corner_count = count, .area = polygon_area(v, count)};
    for (int i = 0; i < count; i++)
        *ARENA_PUSH(&hand->arena, mesh->corners, mesh->corner_count, hand->corner_capacity) =
            hand_vertex(hand, v[i]);
}

void reconstruct_hand_square(Hand *hand, double x, double y, double side, int material) {
    Vec3 v[4] = {{x, y, 0}, {x + side, y, 0}, {x + side, y + side, 0}, {x, y + side, 0}};
    reconstruct_hand_add(hand, v, 4, material, 1);
}

void reconstruct_hand_finish(Hand *hand) {
    Mesh *mesh = &hand->mesh;
    int *old = mesh->corners, *corners = NULL, count = 0, capacity = 0;
    for (int e = 0; e < mesh->element_count; e++) {
        Element *element = &mesh->elements[e];
        int first = count;
        for (int i = 0; i < element->corner_count; i++) {
            int a = old[element->first_corner + i],
                b = old[element->first_corner + (i + 1) % element->corner_count];
            Vec3 from = mesh->vertices[a], along = vec3_sub(mesh->vertices[b], from);
            double square = vec3_dot(along, along), done = 0;
            for (int next = a; next >= 0;) {
                *ARENA_PUSH(&hand->arena, corners, count, capacity) = next;
                next = -1;
                double nearest = 1 - 1e-9;
                for (int v = 0; v < mesh->vertex_count; v++) {
                    Vec3 p = vec3_sub(mesh->vertices[v], from);
                    double t = vec3_dot(p, along) / square;
                    bool on = vec3_length(vec3_sub(p, vec3_scale(along, t))) < 1e-9;
                    if (on && t > done + 1e-9 && t < nearest) nearest = t, next = v;
                }
                done = nearest;
            }
        }
        element->first_corner = first;
        element->corner_count = count - first;
    }
    mesh->corners = corners;
    mesh->corner_count = count;
}

RadSolution reconstruct_dark(const Mesh *mesh, Arena *arena) {
    RadSolution s = {.element_count = mesh->element_count};
    s.radiosity = arena_alloc(arena, (size_t)mesh->element_count, sizeof *s.radiosity);
    return s;
}

void reconstruct_set(RadSolution *s, int element, double b) {
    for (int c = 0; c < 3; c++) s->radiosity[element][c] = b * (c + 1);
}

void reconstruct_hand_quarters(Hand *hand, Random *random, double x, double y, double side, int depth) {
    if (depth == 0 || (depth < 4 && random_between(random, 0, 1) < 0.4)) {
        reconstruct_hand_square(hand, x, y, side, 0);
        return;
    }
    for (int k = 0; k < 4; k++)
        reconstruct_hand_quarters(hand, random, x + k % 2 * side / 2, y + k / 2 * side / 2, side / 2,
                                  depth - 1);
}

Lit *reconstruct_room(void) {
    Lit *lit = lit_new();
    lit_box(lit, vec3(0, 0, 0), vec3(5, 4, 2.5), true, LIT_WALL, 0);
    lit_box(lit, vec3(1, 1, 0), vec3(2.3, 2.4, 1.1), false, LIT_RED, 0);
    lit_quad(lit, vec3(3, 1, 0.4), vec3(4.7, 1.2, 0.4), vec3(4.1, 3.5, 0.4), vec3(3.2, 2.9, 0.4), LIT_RED);
    lit_lamp(lit, vec3(3, 2, 2.2));
    lit_finish(lit, 0.3, 2);
    return lit;
}
