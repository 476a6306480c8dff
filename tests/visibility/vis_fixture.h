// vis_fixture.h - buildings with their cells and trees.
#ifndef TESTS_VIS_FIXTURE_H
#define TESTS_VIS_FIXTURE_H

#include "tests/support/prt_scene.h"
#include "tests/support/support.h"

typedef struct Made {
    Arena arena;
    Building *building;
    CellGraph graph;
    StabForest forest;
} Made;

void vis_check_make(Made *m, uint64_t seed, int nx, int ny, int storeys, int threads, int max_nodes);

// Two sets are separated by a line iff they are by one through two of their points.
bool vis_check_separable(const Vec2 *left, const Vec2 *right, int count);

// Is there one of any direction? The directions of such lines end where a line touches two ends: next to these it is
// looked for.
bool vis_check_crossed_inside(const Vec2 *left, const Vec2 *right, int count);

// Cells convex, each way on both its cells; portals and surfaces together have the area of the cell's boundary.
// In the cell, or no more than a micrometre beyond.
bool vis_check_is_in(const CellGraph *g, int c, Vec3 p);

// Portals lie between their cells, surfaces face into theirs.
void vis_check_expect_placed(const CellGraph *g, const char *name);

void vis_check_expect_closed(const CellGraph *g, int c, double expected, const char *name, double tolerance);

// The same building turned and far away, its cells anew.
void vis_check_turn_away(Made *m, uint64_t seed);

void vis_check_add_region(Arena *arena, Building *b, const Vec2 *points, int count, double z0, double z1);

#endif
