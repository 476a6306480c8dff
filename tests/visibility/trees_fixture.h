// trees_fixture.h - trees of a building.
#ifndef TESTS_TREES_FIXTURE_H
#define TESTS_TREES_FIXTURE_H

#include "engine/core/memory.h"
#include "tests/support/files/hostile.h"
#include "tests/support/support.h"
#include "visibility/pairs/pairs.h"

typedef struct Grown {
    Arena arena;
    Building building;
    CellGraph graph;
    PairSet set;
    StabForest forest;
} Grown;

void trees_grow(Grown *g, int threads, bool known);

// Sight is symmetric, and trees hold the cells that their roots see, each way through cells that they see.
void trees_expect_settled(const StabForest *f);

typedef struct Lines {
    long walked, far;  // of these through five portals or more
} Lines;

// Lines from a cell towards portals that it sees, so that they go far; each way that one takes is a path of the tree.
void trees_walk_lines(const char *path, const Grown *g, int cell, Random *random, Lines *lines);

#endif
