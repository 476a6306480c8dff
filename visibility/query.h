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

// A portal as a cell has it: all that most tests need, side by side for the cells' contacts.
typedef struct Gate {
    Plane plane;            // of the portal, pointing into the cell
    Vec3 centre, half;      // of the box around its corners, and half its size
    int way, portal, cell;  // 2 * portal, or one more from its cell[1]; `cell` lies beyond
} Gate;

// How the view goes through a portal.
typedef enum Passage {
    PASSAGE_NONE,  // not at all
    PASSAGE_ALL,   // all of it: the eye is in the portal
    PASSAGE_EDGE,  // in a thin wedge along its plane, of which the eye is part
    PASSAGE_PART   // through what is in view of it
} Passage;

// What is in view of a portal. The polygon lies in the graph or in one of the buffers.
typedef struct ViewPart {
    const Vec3 *polygon;
    int count;
    Vec3 middle;      // from the eye
    double distance;  // of the nearest corner, metres
    Vec3 buffer[2][MAX_CORNERS];
} ViewPart;

// Corners of what is in view of a portal, as the walk without trees keeps it; where it has more, all of the view passes.
enum { VIEW_CORNERS = 12 };

// Of a portal in one direction, through which the view goes in the walk without trees.
typedef struct PortalView {
    unsigned frame;     // the query it belongs to
    Passage passage;    // so far
    bool whole;         // it can show no more
    int passes, place;  // how often it was gone through; its place in the queue, or -1
    int count;
    double distance;
    Vec3 v[VIEW_CORNERS];
} PortalView;

struct VisQuery {
    const CellGraph *graph;
    const StabForest *forest;
    Cone *cones;        // [depth of the deepest tree + 1] one for each level; the first is the eye's own
    Gate *gates;        // [contact_count] as CellGraph.contacts
    int *gate_of;       // [2 * portal_count] from cell[0] and from cell[1]
    PortalView *views;  // [2 * portal_count] from cell[0] and from cell[1]
    int *queue;         // [2 * portal_count] views to go through, a heap by distance
    int queue_count;
    VisibleCell *spare;  // [cell_count] for sorting
    // The objects of cell c are cell_objects[cell_first[c]] .. ; none are listed of cells that hold many.
    int *cell_first, *cell_objects;
    int *cell_slot;           // [cell_count] place in `cells`, valid when cell_frame says so
    unsigned *cell_frame;     // [cell_count]
    VisibleCell *cells;       // [cell_count]
    uint64_t *drawn;          // bit per object
    unsigned *object_tested;  // [object_count] the last cone it was tested against
    int *objects;             // [object_count] the result
    int *polygons_of;         // [object_count]
    int *plugs;               // [object_count] the opening whose door it is the plug of, or -1
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
// Before all queries.
void query_list_gates(VisQuery *q, Arena *arena);
// What the cone shows of a portal.
Passage query_clip(VisQuery *q, const Cone *cone, const Gate *gate, ViewPart *out);
// The cone beyond it.
void query_beyond(const VisQuery *q, const Cone *cone, Passage passage, const Gate *gate,
                  const ViewPart *part, Cone *out);
// Could the eye, a hair's breadth from the portal's plane, be in the portal?
bool query_eye_at_portal(const CellGraph *graph, const Portal *portal, Vec3 eye);
// The half of the plan to the left of the line from the eye along `direction`.
Plane query_left_of(Vec2 eye, Vec2 direction);

// query.c: goes through a portal with the cone beyond it; false where a closed door ends the view.
bool query_enter(VisQuery *q, const Gate *gate, const Cone *beyond, double distance);

// query_walk.c: the walk without trees.
void query_walk(VisQuery *q, int cell);

// query_cell.c: marks what of a cell's objects the cone meets.
void query_draw_cell(VisQuery *q, int cell, const Cone *cone);
void query_list_objects(VisQuery *q, Arena *arena);  // before all queries
static inline bool query_lists_objects(const VisQuery *q, int cell) {
    return q->cell_first[cell] < q->cell_first[cell + 1];
}
bool query_box_outside(Box box, const Plane *planes, int count);

#endif
