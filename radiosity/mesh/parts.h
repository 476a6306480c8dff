// parts.h - a building in parts, groups of cells that lie together, whose light is found side by side.
#ifndef RADIOSITY_PARTS_H
#define RADIOSITY_PARTS_H

#include "engine/core/box_tree.h"
#include "radiosity/mesh/mesh.h"

// Which part each object and each cell belongs to, and the cells that objects touch. Lives in the arena of the call that made it.
typedef struct Parts {
    const CellGraph *graph;
    int count;
    int *owner, *cell_owner;  // [object_count], [cell_count]
    int *first, *cell;        // object o touches cell[first[o]] .. cell[first[o + 1] - 1]
    BoxTree boxes;            // of objects
} Parts;

// Parts of `cells` cells at most. They depend on the building alone. Outdoors much is seen, which each part that sees any of it has in its
// mesh: so cells that see some have parts of their own. The forest tells what is seen.
Parts parts_of(const CellGraph *graph, const StabForest *forest, int cells, Arena *arena);

// The objects of which the mesh of part `own` is made. Elements are cut along things as near as `close`,
// metres.
MeshPart part_of(const Parts *parts, const StabForest *forest, int own, double close, Arena *arena);

#endif
