// figure.h - plans and stab trees as figures, through the drawing table: for files and for the overlay alike.
#ifndef VISIBILITY_FIGURE_H
#define VISIBILITY_FIGURE_H

#include "engine/core/draw.h"
#include "visibility/vis.h"

// What of the building lies at height z, in two layers: the ground (cells by kind, portals as thin lines) and above
// it the lines (walls, doors with their swing, windows, names). What is drawn between them lies under the walls.
void figure_ground(const CellGraph *graph, double z, const Draw *draw);
void figure_lines(const CellGraph *graph, double z, const Draw *draw);

// The cells of the tree of `root` at height z, shaded by depth, and a sightline into each (dashed).
void figure_seen(const CellGraph *graph, const StabForest *forest, int root, double z, const Draw *draw);

// The tree of `root` as nodes and edges inside `area`, to `max_depth` levels; nodes are labelled by room or number.
void figure_tree(const CellGraph *graph, const StabForest *forest, int root, Box area, int max_depth,
                 const Draw *draw);

// A line through all portals on the way to `node`, from inside the root cell to inside the node's, in plan.
// Returns false for the root itself.
bool figure_sightline(const CellGraph *graph, const StabForest *forest, int node, Arena *scratch,
                      Vec2 ends[2]);

#endif
