// figure.h - plans and stab trees as figures, through the drawing table: for files and for the overlay alike.
#ifndef VISIBILITY_FIGURE_H
#define VISIBILITY_FIGURE_H

#include "engine/core/draw.h"
#include "visibility/vis.h"

// The building at height z, in two layers: the ground (cells by kind, portals as thin lines) and above
// it the lines (walls, doors with their swing, windows, names). Drawings between the two lie under the walls.
void figure_ground(const CellGraph *graph, double z, const Draw *draw);
void figure_lines(const CellGraph *graph, double z, const Draw *draw);

// The cells of the tree of `root` at height z, shaded by depth, and a sightline into each (dashed).
void figure_seen(const CellGraph *graph, const StabForest *forest, int root, double z, const Draw *draw);

// The tree of `root` as nodes and edges inside `area`, to `max_depth` levels; nodes are labelled by room or number.
void figure_tree(const CellGraph *graph, const StabForest *forest, int root, Box area, int max_depth,
                 const Draw *draw);

// The parts of figures: one cell or region, in a style of the caller's.
bool figure_cuts(const CellGraph *graph, int cell, double z);  // is the cell there at height z?
void figure_fill(const CellGraph *graph, int cell, const DrawStyle *style, const Draw *draw);
void figure_walls(const CellGraph *graph, int cell, double z, const DrawStyle *style, const Draw *draw);
// The polygons of a soup where they cross height z, in an area; heights of the area do not matter.
void figure_polygons(const CellGraph *graph, double z, Box area, const DrawStyle *style, const Draw *draw);
// Does the portal cross height z, and between which ends?
bool figure_portal(const CellGraph *graph, int portal, double z, Vec2 ends[2]);
// Each portal belongs to the first of its cells.
void figure_portals(const CellGraph *graph, int cell, double z, const DrawStyle *style, const Draw *draw);
// Where in the region and in the area a rectangle of that size has room, metres: as near to the region's middle as there
// is a place.
bool figure_name_place(const Building *building, int region, Box area, double width, double height,
                       Vec2 *middle);

#endif
