// build.h - the steps that make a CellGraph, in their order. Each reads the results of the earlier ones.
#ifndef VISIBILITY_BUILD_H
#define VISIBILITY_BUILD_H

#include "visibility/vis.h"

// State that the steps share and the graph does not keep.
typedef struct CellBuilder {
    const Building *building;
    const VisOptions *options;
    Arena *arena;  // of the result
    Arena *scratch;
    CellGraph *graph;
    int *
        ring_edge;  // [plan_count] the edge of a region's ring that a cell's edge is, -1: a cut through the region
    bool *edge_outer;  // [plan_count] the edge lies on the world's border: nothing stands there
    int plan_capacity, edge_capacity, outer_capacity, portal_capacity, portal_vertex_capacity;
    int polygon_capacity, vertex_capacity, object_capacity;
} CellBuilder;

// cells.c: convex prisms from the regions of a plan, their portals and their surfaces.
bool build_regions(CellBuilder *builder, Error *error);
// given.c: cells and portals as they are given, and the results of the other steps for a graph without walls.
bool build_given(CellBuilder *builder, Error *error);
// portals.c: where cells touch, vertically and horizontally.
void build_portals(CellBuilder *builder);
// surfaces.c: the surfaces that close cells where no portal is, and the closed leaves of doors.
void build_surfaces(CellBuilder *builder);
// squares.c: which cells lie where in plan, and which objects touch which squares of which cells.
void build_locator(CellBuilder *builder);
void build_squares(CellBuilder *builder);

// leaves.c: all that a leaf sweeps on its way, from z0 to z1: plan boxes whose union holds it at every share, z = 0.
enum { SWEPT_STEPS = 33 };
typedef struct SweptLeaf {
    Vec3 plan[SWEPT_STEPS][4];  // counter-clockwise
    double z0, z1;
} SweptLeaf;
void build_swept(const CellGraph *graph, int object, SweptLeaf *out);

// ways.c
// Whether a portal with its plane and its corners is upright, and its plan ends.
void portal_set_ends(Portal *portal, const Vec3 *corners);
// Lists the portals of each cell, once all portals are there.
void list_ways(CellBuilder *builder);
// The plan polygon of a cell at height z; `out` needs room for edge_count vertices. Counter-clockwise from above.
int cell_polygon(const CellGraph *graph, const Cell *cell, double z, Vec3 *out);

// Plan polygons are clipped with room for this many vertices; cells have at most half as many edges.
enum { BUILD_MAX_VERTICES = 128 };

#endif
