// reconstruct_fixture.h - meshes with light that is known.
#ifndef TESTS_RECONSTRUCT_FIXTURE_H
#define TESTS_RECONSTRUCT_FIXTURE_H

#include "radiosity/show/reconstruct.h"
#include "tests/support/lit_fixture.h"

// A mesh of polygons as given: each is a face of one element.
typedef struct Hand {
    Arena arena;
    CellGraph graph;
    Object objects[2];
    Mesh mesh;
    int element_capacity, face_capacity, corner_capacity, vertex_capacity;
} Hand;

void reconstruct_hand_start(Hand *hand);

void reconstruct_hand_add(Hand *hand, const Vec3 *v, int count, int material, int object);

void reconstruct_hand_square(Hand *hand, double x, double y, double side, int material);

// Vertices of neighbours become corners, as mesh_build has it.
void reconstruct_hand_finish(Hand *hand);

RadSolution reconstruct_dark(const Mesh *mesh, Arena *arena);

void reconstruct_set(RadSolution *s, int element, double b);

// A quarter tree of squares, split at random: sizes differ by any power of two.
void reconstruct_hand_quarters(Hand *hand, Random *random, double x, double y, double side, int depth);

// A room with a box on its floor and a wall that is no rectangle: polygons cut into squares and clipped ones.
Lit *reconstruct_room(void);

#endif
