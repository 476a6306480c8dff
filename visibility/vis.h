// vis.h - cells, portals and stab trees, built once; the visible set, asked every frame.
//
// Source: S. J. Teller & C. H. Sequin, Visibility Preprocessing for Interactive Walkthroughs, 1991; K. Shudo,
// S. Murata & K. Matsuyama (Oki), Visibility determination in an indoor walkthrough system and its uses.
#ifndef VISIBILITY_VIS_H
#define VISIBILITY_VIS_H

#include <stdint.h>

#include "engine/core/progress.h"
#include "maps/building/building.h"
#include "visibility/cell_rows.h"

// A convex polyhedron of free space. Of a building of regions it is an upright prism, part of one region: its plan
// polygon from z0 to z1. Otherwise its faces bound it, and plan, z0 and z1 are its shadow and its extent.
typedef struct Cell {
    int region;  // -1 where the building has none
    // The plan polygon in CellGraph.plan, counter-clockwise; vertices may be collinear.
    int first_edge, edge_count;
    int first_face, face_count;  // in CellGraph.faces; none of a prism
    int first_way, way_count;    // in CellGraph.ways
    double z0, z1;
    Box box;
    bool outdoors;  // of a building without regions: it reaches the border of the building
} Cell;

// A convex planar polygon shared by two cells, with no surface in it.
typedef struct Portal {
    int cell[2];
    int first_vertex, vertex_count;  // in CellGraph.portal_vertices; counter-clockwise seen from cell[0]
    Plane plane;                     // n points from cell[1] to cell[0]
    bool horizontal;   // not upright: it has an area in plan (in a floor or ceiling; of a soup, any slope)
    Vec2 left, right;  // of an upright portal: its plan ends, seen when crossing from cell[0] to cell[1]
    int door;          // opening whose closed leaf fills it, else -1
} Portal;

// A directed portal: one way out of a cell.
typedef struct Way {
    int portal, cell;  // `cell` lies beyond
} Way;

// The squares of side `size` that cover a cell's plan (Oki 2.2); square (i, j) has index first_square + j*nx + i.
typedef struct SquareGrid {
    Vec2 origin;
    double size;
    int nx, ny, first_square;
} SquareGrid;

// All that is drawn: the building's polygons and the surfaces of the cells, as one list. Index order is draw
// order; among coincident surfaces the lowest index is seen.
// Read only once it is made: any number of threads. It lives in the arena of the call that made it; its building outlives it.
typedef struct CellGraph {
    const Building *building;
    Cell *cells;
    Vec2 *plan;
    Plane *faces;  // pointing into their cells
    Way *ways;
    Portal *portals;
    Vec3 *portal_vertices;
    int cell_count, plan_count, face_count, way_count, portal_count, portal_vertex_count;
    // Objects: first the building's own (same indices), then the surfaces of each cell and the closed leaves.
    Object *objects;
    Polygon *polygons;
    Vec3 *vertices;
    Box *object_boxes;   // [object_count]; of a leaf, the box of its whole sweep
    int *surface_first;  // [cell_count + 1] the surfaces of cell c are objects surface_first[c] ..
    int object_count, polygon_count, vertex_count;
    // Which objects touch which squares of which cells (within `touch`). Run s is
    // square_objects[square_first[s]] .. square_objects[square_first[s + 1] - 1].
    SquareGrid *grids;  // [cell_count]
    int *square_first;  // [square_count + 1]
    int *square_objects;
    int square_count, square_object_count;
    // Which cells reach into which squares of the plan, for point location: as above.
    SquareGrid locator;
    int *locator_first;  // [locator.nx * locator.ny + 1]
    int *locator_cells;
    Box box;
    // How near a polygon must come to a cell to be registered there, metres: VIS_TOUCH, of a soup by its size.
    double touch;
    int dropped_slivers;  // surfaces and portals without area (VIS_SLIVER) that were left out
    const struct VisQuery
        *query;  // whose lists other queries share (vis_share_query); NULL: each has its own
} CellGraph;

// How near a polygon must come to a cell of a building of regions to be registered there, metres: more than the grid and
// than any coplanarity noise, less than any wall.
#define VIS_TOUCH 0.002

// Surfaces and horizontal portals of less area than this are left out, m^2: a hundredth of a square of the grid.
#define VIS_SLIVER 1e-8

// The same graph, where objects touch the squares of other polygons as well: of object o those from first[o] to first[o + 1] - 1,
// with up to 128 vertices. Shares all else with `graph`.
void vis_register(const CellGraph *graph, const Polygon *polygons, const Vec3 *vertices, const int *first,
                  Arena *arena, CellGraph *out);

// How cells are laid out in squares and trees bounded.
typedef struct VisOptions {
    double square;  // side of the squares of a cell, metres, 0.25 .. 100
    int threads;    // 0: all cores
    int max_nodes;  // of one cell's stab tree; beyond it the tree is dropped and the visible set kept
    // The cells that each cell may see, itself among them, symmetric (see pairs.h); NULL: not known beforehand.
    const CellRows *known;
} VisOptions;
// Squares of 1 m, all cores, trees of 5,000 nodes at most.
VisOptions vis_default_options(void);

// Cells, portals and surfaces of a building of any form. Fails on one without free space.
bool vis_build_cells(const Building *building, const VisOptions *options, Arena *arena, CellGraph *out,
                     Error *error);

// A building of more cells is not searched in one matrix of pairs, whose memory and time grow with their square. Where it cannot be
// searched group by group either (window.h), its trees rest on separating planes alone.
enum { VIS_MANY_CELLS = 8192 };

// One visible cell of a stab tree: reached from its parent through `portal`. Depth-first; `next` is the sibling.
typedef struct StabNode {
    int cell, portal, parent, next;  // -1: none
} StabNode;

// The tree of cell c is nodes[root[c]] .. nodes[root[c + 1] - 1], the first being c itself; a cell whose tree was
// too large has one node only and bounded[c] set: its visible set holds all the same.
// Read only once it is made: any number of threads. It lives in the arena of the call that made it, and holds no pointer to the graph.
typedef struct StabForest {
    StabNode *nodes;
    int *root;                          // [cell_count + 1]
    unsigned char *bounded;             // [cell_count]
    CellRows seen;                      // row i: the cells that may be seen from i; symmetric
    int node_count, cell_count, words;  // words of a row of all cells
} StabForest;

// May a point of cell `from` see one of cell `to`, all doors open?
static inline bool vis_sees(const StabForest *forest, int from, int to) {
    return cell_rows_has(&forest->seen, from, to);
}

// Conservative: the way that a straight line from anywhere in c takes through portals is a path of c's tree. All doors
// open. A tree that is estimated at several times max_nodes is dropped before it has so many. The same result on any
// number of threads. Returns false only when progress asked to stop.
bool vis_build_forest(const CellGraph *graph, const VisOptions *options, const Progress *progress,
                      Arena *arena, StabForest *out);

// A hash of all cells and portals, by which files that were made for others are known.
uint64_t vis_geometry_hash(const CellGraph *graph);

// The .vis file: cells are made again from the building; the forest is stored under the building's hash.
bool vis_save(const char *path, const CellGraph *graph, const StabForest *forest, Error *error);
// False, and a sentence, where the file is damaged or of another building, version or grid of squares.
bool vis_load(const char *path, const CellGraph *graph, Arena *arena, StabForest *out, Error *error);

// Where a cell lies: its region, or, of a building without regions, a room without a name or the outdoors.
const Region *vis_region(const CellGraph *graph, int cell);

// A cell that holds `point` (boundaries included), or -1. `hint` is tried first, then its
// neighbours; -1 for none.
int vis_locate(const CellGraph *graph, Vec3 point, int hint);

// The cell that holds the largest part of a convex polygon, -1 where none holds more than VIS_SLIVER of it; the middle of that
// part's corners, a point of the cell, and its area, m^2. `scratch` grows by some kB.
int vis_locate_part(const CellGraph *graph, const Vec3 *polygon, int count, Arena *scratch, Vec3 *middle,
                    double *area);

// Does the state of its door show this object? All but the plugs of open doors. `door_open` as for vis_query.
bool vis_shown(const Object *object, const float *door_open);

// Puts the leaves of doors where `door_open` has them: writes their vertices. `vertices` [vertex_count] is the caller's
// copy of the graph's, in which leaves are as when closed.
void vis_pose(const CellGraph *graph, const float *door_open, Vec3 *vertices);
// Such a copy, in the arena.
Vec3 *vis_posed(const CellGraph *graph, const float *door_open, Arena *arena);

// Does the polygon let light through? Glass never hides.
static inline bool vis_is_glass(const CellGraph *graph, int polygon) {
    return graph->building->materials[graph->polygons[polygon].material].alpha < 1;
}

// The work of following chains of portals, for tables: the same on any number of threads.
typedef struct ChainWork {
    long long chains;      // sequences of portals followed
    long long clips;       // portals clipped by planes
    long long separators;  // separating planes made
    long long given_up;    // searches that became too long: their pairs in doubt count as seen
} ChainWork;

// Ways to leave out of a view the objects that it does not show.
typedef enum Culling {
    CULL_NONE,       // nothing is left out
    CULL_FRUSTUM,    // objects outside the view volume
    CULL_PORTALS,    // portals clipped at run time, no trees (Luebke & Georges 1995)
    CULL_PLAN,       // stab trees, horizontal clipping only (Oki 3.1)
    CULL_STAB,       // stab trees, portals clipped in three dimensions
    QUERY_CULLINGS,  // vis_query takes those before
    // Those of views of form factors alone (viewer_look):
    CULL_DEPTH = QUERY_CULLINGS,  // faces behind those drawn before
    CULL_CELLS,                   // faces in no cell of the stab tree
    CULLINGS
} Culling;
extern const char
    *const CULLING_NAMES[CULLINGS];  // "none", "frustum", "portals", "plan", "stab", "depth", "cells"

// A place to look from, and the part of the view that is kept.
typedef struct Eye {
    Vec3 position;
    Plane frustum[6];   // keep the positive side; all planes but the far one may pass through the eye
    int frustum_count;  // 0: all directions
    // A point of a surface, exactly: it is before that surface however near. Otherwise an eye too near a wall for a rasteriser to tell its
    // sides, a millimetre, sees what is seen from any cell within that distance.
    bool on_surface;
    // [start_count] Where the eye is the image of an eye in a mirror, behind that mirror: the cells that the mirror touches, in which
    // the view begins; the frustum keeps what lies before the mirror. 0: the view begins at the eye, in the eye's cell.
    const int *start;
    int start_count;
} Eye;

// A cell that may be seen.
typedef struct VisibleCell {
    int cell;
    double distance;  // from the eye to its nearest portal as it was reached, metres; 0 for the eye's cell
} VisibleCell;

// The memory of a query, sized once for a graph. One thread's at a time; it lives in the arena of vis_query_new, and the graph and the
// forest outlive it.
typedef struct VisQuery VisQuery;
// All memory is taken here.
VisQuery *vis_query_new(const CellGraph *graph, const StabForest *forest, Arena *arena);
// From now on queries of the graph share lists that lie in the arena: where many are made of a large building, each takes a part of the
// memory and of the time.
void vis_share_query(CellGraph *graph, const StabForest *forest, Arena *arena);

// The visible set, and the work of finding it. It lies in the query, until this is asked again.
typedef struct VisResult {
    const VisibleCell *cells;      // near to far
    const int *objects;            // to draw, increasing; those whose door state hides them are left out
    int cell_count, object_count;  // cell_count 0: all objects in the frustum are drawn
    int polygon_count;             // in these objects
    int eye_cell;                  // as it was told
    int portals_tested, objects_tested;
} VisResult;

// `door_open` [opening_count]: how far each door is open, 0 closed .. 1 wide open (see Leaf), or NULL for all wide open.
// A door that is not quite closed blocks nothing. An eye on a portal, to a rasteriser's precision, is in the cells on both
// sides: it sees all that is seen from either. Allocates nothing. The result stays valid until the next query. `cell` is the eye's
// cell, from vis_locate, or -1; of an eye with `start` it is not asked. An eye in no cell but in the box of the building, as in a wall that
// it flies through, sees what lines from it meet that enter free space in a cell within a quarter of a metre. Where there is none, as
// outside the building, it sees everything in the frustum.
VisResult vis_query(VisQuery *query, const Eye *eye, int cell, const float *door_open, Culling culling);

#endif
