// lit_fixture.h - small buildings with light in them, for tests of shooting.
#ifndef TESTS_LIT_FIXTURE_H
#define TESTS_LIT_FIXTURE_H

#include "engine/core/random.h"
#include "radiosity/shoot/shoot.h"

typedef struct Lit {
    Arena arena;
    Building *building;
    CellGraph graph;
    StabForest forest;
    Mesh mesh;
} Lit;

// Materials of soups made here.
enum { LIT_WALL, LIT_LAMP, LIT_RED };

// A soup without polygons. Walls reflect half, lamps emit (12, 10, 6) W/m^2 and reflect nothing, red is red.
Lit *lit_new(void);
// A material of a picture, `texels` [height * width * 4] as in Texture.texels; it reflects the picture's mean. Returns its index.
int lit_picture(Lit *lit, int width, int height, const uint8_t *texels, TextureMap map);
void lit_quad(Lit *lit, Vec3 p, Vec3 q, Vec3 r, Vec3 s, int material);
// The six sides of a box, looking inwards (a room) or outwards (furniture); `mask` bit i leaves side i out: -x, +x, -y,
// +y, -z, +z.
void lit_box(Lit *lit, Vec3 low, Vec3 high, bool inwards, int material, int mask);
// A square lamp of side 1 that looks down.
void lit_lamp(Lit *lit, Vec3 middle);
// Cells, trees and mesh of it; without more, of elements alike that nothing cuts.
void lit_finish_with(Lit *lit, const MeshOptions *mesh);
void lit_finish(Lit *lit, double element, int per_patch);

// 3 x 3 rooms with passages and doors of a building of regions (fixture.h); every piece of furniture has a glowing top.
Lit *lit_rooms(uint64_t seed);

void lit_free(Lit *lit);

// Radiosity from nothing; fails the running test where it cannot begin.
RadReport lit_shoot(Lit *lit, const RadOptions *options, RadSolution *out);

#endif
