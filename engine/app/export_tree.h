// export_tree.h - a building as a tree of named things: storeys, rooms, openings, and what stands in them.
#ifndef APP_EXPORT_TREE_H
#define APP_EXPORT_TREE_H

#include "visibility/vis.h"

typedef struct ExportNode {
    const char *name;
    int parent;        // -1: the root
    int leaf;          // in Building.leaves: moves as it; -1
    int first_object;  // of CellGraph; its objects are first_object, next[first_object] ..; -1: none
    int last_object;
} ExportNode;

// The root is node 0; parents come before their children.
typedef struct ExportTree {
    ExportNode *nodes;
    int count, capacity;
    int *next;  // [graph->object_count] -1: the last of its node
} ExportTree;

// Of those objects alone that `wanted` [object_count] tells.
ExportTree export_tree(const CellGraph *graph, const bool *wanted, Arena *arena);

#endif
