// query.h - what the files of the query share: the cone that narrows from portal to portal, and the query under way.
#ifndef VISIBILITY_QUERY_H
#define VISIBILITY_QUERY_H

#include "visibility/build.h"

enum { MAX_PLANES = 24, MAX_CORNERS = 2 * MAX_PLANES + 8 };

// Rasterisers compute in floats: 2e-5 m is half a digit at 300 m from the middle of the building.
#define POSITION_SLACK 2e-5
// An eye this near a portal's plane counts as on it: the whole volume passes if it is at the portal itself, and a thin
// wedge along the plane if the portal is seen edge-on from afar. Metres.
#define ON_PLANE 1e-3

typedef struct Cone {
    Plane plane[MAX_PLANES];  // all through the eye, but for those of the caller's frustum
    int count;
    // In plan: directions from `from` counter-clockwise to `to`, less than a half turn; or all around.
    bool all_around;
    Vec2 from, to;
} Cone;

struct VisQuery {
    const CellGraph *graph;
    const StabForest *forest;
    Cone *cones;  // [depth_limit + 2] one for each level of the walk
    int depth_limit;
    unsigned *on_path;        // [cell_count] how often it lies on the way
    unsigned *portal_frame;   // [2 * portal_count] the last query that went through it, by direction
    unsigned *portal_passes;  // [2 * portal_count] how often it did
    VisibleCell *spare;       // [cell_count] for sorting
    // The objects of cell c are cell_objects[cell_first[c]] .. ; none are listed of cells that hold many.
    int *cell_first, *cell_objects;
    int *cell_slot;           // [cell_count] place in `cells`, valid when cell_frame says so
    unsigned *cell_frame;     // [cell_count]
    VisibleCell *cells;       // [cell_count]
    uint64_t *drawn;          // bit per object
    unsigned *object_tested;  // [object_count] the last cone it was tested against
    int *objects;             // [object_count] the result
    unsigned frame, cone_serial;
    // Of the query under way:
    const Eye *eye;
    const float *door_open;
    VisMethod method;
    const uint64_t *limit;  // only cells of this visible set are entered, or NULL
    VisResult result;
};

// query_cone.c
void query_first_cone(VisQuery *q, Cone *cone);
// The cone beyond `portal`, crossed from `cell`. Returns false when nothing of it is seen.
bool query_narrow(VisQuery *q, const Cone *cone, int portal, int cell, Cone *out, double *distance);
// Could the eye, a hair's breadth from the portal's plane, be in the portal?
bool query_eye_at_portal(const CellGraph *graph, const Portal *portal, Vec3 eye);
// The half of the plan to the left of the line from the eye along `direction`.
Plane query_left_of(Vec2 eye, Vec2 direction);

// query_cell.c: marks what of a cell's objects the cone meets.
void query_draw_cell(VisQuery *q, int cell, const Cone *cone);
void query_list_objects(VisQuery *q, Arena *arena);  // once, before all queries
bool query_box_outside(Box box, const Plane *planes, int count);

#endif
