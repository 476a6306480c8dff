// forest.h - what the two files that make stab trees share.
#ifndef VISIBILITY_FOREST_H
#define VISIBILITY_FOREST_H

#include "visibility/vis.h"

// The data from which all trees of a building are grown; read only, on any number of threads.
typedef struct TreeSource TreeSource;
TreeSource *tree_source_new(const CellGraph *graph, const VisOptions *options, Arena *arena);

typedef struct Tree {
    StabNode *nodes;  // malloc'd; of this tree alone, depth-first, numbered from 0
    int count;
    bool bounded;
    long long spent;  // work
} Tree;

// The data with which one thread grows trees.
typedef struct TreeGrower TreeGrower;
TreeGrower *tree_grower_new(const TreeSource *source, Arena *arena);
void tree_grower_end(TreeGrower *grower);

// How much work all trees may take (ways_work).
long long tree_work(const TreeSource *source);
// How many times the work of a tree that was given up counts: of a large building, more than its own, so that the rest are soon given up.
int tree_waste(const TreeSource *source);

// Returns the tree of a cell, or the root alone where it is too large or takes more work than `allowed`, and marks in `row`
// [words] the cells that may be seen from it.
Tree tree_grow(TreeGrower *grower, int cell, long long allowed, uint64_t *row);

#endif
