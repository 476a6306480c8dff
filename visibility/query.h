// query.h - what the files of the query share: the cone that narrows from portal to portal, and the query under way.
#ifndef VISIBILITY_QUERY_H
#define VISIBILITY_QUERY_H

#include "visibility/build.h"

enum { MAX_PLANES = 24, MAX_CORNERS = 2 * MAX_PLANES + 8 };

// Rasterisers compute in floats: 2e-5 m is half a digit at 300 m from the middle of the building.
#define POSITION_SLACK 2e-5
// They snap to 1/256 of a pixel: 5e-5 covers views down to 100 pixels a radian.
#define ANGLE_SLACK 5e-5
// An eye this near a portal's plane counts as on it: the whole volume passes if it is at the portal itself, and a thin
// wedge along the plane if the portal is seen edge-on from afar. Metres.
#define ON_PLANE 1e-3

typedef struct Cone {
    Plane plane[MAX_PLANES];  // all through the eye, but for those of the caller's frustum
    int count;
    // In plan: directions from `from` counter-clockwise to `to`, less than a half turn; or all around.
    bool all_around;
    Vec2 from, to;
    // Beyond an upright rectangle the planes are four, and these are the same: the wedge, and from below to above it
    // heights over the plan offset u from the eye, bottom . u - bottom_slack to top . u + top_slack.
    bool is_slot;
    Vec2 bottom, top;
    double bottom_slack, top_slack;
} Cone;

// A portal as a cell has it: what most tests need in one line of the cache, in the order of CellGraph.contacts.
typedef struct Gate {
    // Of the portal's plane, pointing into the cell; of one that is no upright rectangle n has a third part.
    Vec2 n;
    double d;
    union {
        // Where an upright rectangle begins and ends along gate_along, and in height.
        struct {
            double s0, s1, z0, z1;
        } wall;
        struct {
            double nz;
            int index;  // in VisQuery.sloped
        } other;
    };
    int cell;  // beyond
    unsigned portal : 30;
    bool is_wall : 1, has_door : 1;
} Gate;

// Along an upright portal, counter-clockwise around an eye in front of it.
static inline Vec2 gate_along(const Gate *gate) { return vec2(gate->n.y, -gate->n.x); }
static inline Plane gate_plane(const Gate *gate) {
    return (Plane){{gate->n.x, gate->n.y, gate->is_wall ? 0 : gate->other.nz}, gate->d};
}
// How far the eye is before the portal's plane, metres.
static inline double gate_ahead(const Gate *gate, Vec3 eye) {
    double ahead = gate->n.x * eye.x + gate->n.y * eye.y - gate->d;
    return gate->is_wall ? ahead : ahead + gate->other.nz * eye.z;
}

// A straight line over the foot of an upright portal: its height at a place s along it is at + rise * s.
typedef struct SlotEdge {
    double at, rise;
} SlotEdge;

// What is in view of an upright rectangle: from s0 to s1 along it, between two lines. Places are metres from the eye's
// foot in the portal's plane, counter-clockwise around the eye seen from above; heights are from the eye's.
typedef struct Slot {
    double s0, s1;
    SlotEdge bottom, top;
} Slot;

// How the view goes through a portal.
typedef enum Passage {
    PASSAGE_NONE,  // not at all
    PASSAGE_ALL,   // all of it: the eye is in the portal
    PASSAGE_EDGE,  // in a thin wedge along its plane, of which the eye is part
    PASSAGE_PART   // through what is in view of it
} Passage;

// What is in view of a portal: a slot, or a polygon, which lies in the graph or in one of the buffers.
typedef struct ViewPart {
    bool upright;  // it is a slot
    Slot slot;
    const Vec3 *polygon;
    int count;
    Vec3 middle;      // of the polygon, from the eye
    double distance;  // of the nearest point or corner from the eye, metres
    Vec3 buffer[2][MAX_CORNERS];
} ViewPart;

// Corners of what is in view of a portal, as the walk without trees keeps it; where it has more, all of the view passes.
enum { VIEW_CORNERS = 12 };

// Of a portal that is no upright rectangle: the box around it, its middle and half its size, and what is in view of it.
typedef struct Sloped {
    Vec3 centre, half;
    int count;
    Vec3 v[VIEW_CORNERS];
} Sloped;

// Of a gate, through which the view goes in the walk without trees.
typedef struct PortalView {
    unsigned frame;         // the query it belongs to
    int place;              // in the queue, or -1
    float distance;         // as ViewPart's: it only orders
    unsigned char passage;  // so far
    bool whole;             // it can show no more
    unsigned char passes;   // how often it was gone through
    Slot slot;              // of an upright rectangle; of others see Sloped
} PortalView;

// Of a cell.
typedef struct CellView {
    int first_gate, gate_count;  // in VisQuery.gates
    int first_box, box_count;    // in VisQuery.boxes; none of a cell that holds many objects
    unsigned frame;              // the last query that saw it
    int place;                   // then in VisQuery.cells
} CellView;

// An object as a cell lists it: the middle of its box, from the middle of the building, and half its size, rounded up.
typedef struct ObjectBox {
    float centre[3], half[3];
    int object;
} ObjectBox;

typedef struct ObjectTraits {
    int polygon_count;
    int plug;  // the opening whose door it is the plug of, or -1
} ObjectTraits;

struct VisQuery {
    const CellGraph *graph;
    const StabForest *forest;
    Cone *cones;        // [depth of the deepest tree + 1] one for each level; the first is the eye's own
    Gate *gates;        // [contact_count] as CellGraph.contacts
    int *gate_of;       // [2 * portal_count] from cell[0] and from cell[1]
    PortalView *views;  // [contact_count] as gates
    Sloped *sloped;     // [gates that are no upright rectangles]
    int *queue;         // [contact_count] gates to go through, a heap by distance
    int queue_count;
    CellView *of_cell;        // [cell_count]
    ObjectBox *boxes;         // of cells that hold few
    Vec3 middle;              // of the building
    VisibleCell *cells;       // [cell_count]
    VisibleCell *spare;       // [cell_count] for sorting
    uint64_t *drawn;          // bit per object
    unsigned *object_tested;  // [object_count] the last cone it was tested against
    int *objects;             // [object_count] the result
    ObjectTraits *traits;     // [object_count]
    uint64_t *every_cell;     // a visible set of all
    uint64_t *joined;         // [words] the visible set of an eye at portals
    unsigned frame, cone_serial;
    // Of the query under way:
    const Eye *eye;
    const float *door_open;
    VisMethod method;
    const uint64_t *limit;  // only cells of this visible set are entered
    VisResult result;
};

// query_cone.c
void query_first_cone(VisQuery *q, Cone *cone);
// One half-space more, unless the cone is full: one less makes it larger, and nothing is lost.
static inline void cone_add(Cone *cone, Vec3 n, double d) {
    if (cone->count < MAX_PLANES) cone->plane[cone->count++] = (Plane){n, d};
}
// The two upright planes of the plan wedge.
void cone_add_wedge(Cone *cone, Vec3 eye);
// A plan direction of unit length, turned counter-clockwise (`side` +1) or clockwise (-1) by the slack of what it points
// to, at `length` metres. As good as of unit length.
static inline Vec2 cone_turned(Vec2 direction, int side, double length) {
    double turn = side * (ANGLE_SLACK + POSITION_SLACK / length);
    return vec2(direction.x - turn * direction.y, direction.y + turn * direction.x);
}
// Before all queries.
void query_list_gates(VisQuery *q, Arena *arena);
// What the cone shows of a portal from `ahead` metres before its plane.
Passage query_clip(VisQuery *q, const Cone *cone, const Gate *gate, double ahead, ViewPart *out);
// The cone beyond it.
void query_beyond(const VisQuery *q, const Cone *cone, Passage passage, const Gate *gate,
                  const ViewPart *part, Cone *out);
// Could the eye, a hair's breadth from the portal's plane, be in the portal?
bool query_eye_at_portal(const CellGraph *graph, const Portal *portal, Vec3 eye);

// query_slot.c: is the portal an upright rectangle? Then its place and size are written.
bool query_is_wall(const CellGraph *graph, const Portal *portal, Plane plane, Gate *gate);
// What the cone shows of it, from `ahead` metres before its plane; false: nothing.
bool query_slot_clip(const Cone *cone, const Gate *gate, Vec3 eye, double ahead, Slot *out);
// Of the nearest point from the eye, metres.
double query_slot_distance(const Slot *slot, double ahead);
// Is all of `part` in `slot`? Both are of one gate.
bool query_slot_holds(const Slot *slot, const Slot *part);
// A slot that holds both.
Slot query_slot_union(const Slot *a, const Slot *b, const Gate *gate, Vec3 eye);
// The cone beyond it: its planes, or in plan only its wedge.
void query_slot_cone(const Slot *slot, const Gate *gate, Vec3 eye, bool plan, Cone *out);

// Is a box outside the cone? Its middle from the eye, and half its size.
bool query_slot_outside(const Cone *cone, Vec3 centre, Vec3 half);

// query.c: goes through a portal with the cone beyond it; false where a closed door ends the view.
bool query_enter(VisQuery *q, const Gate *gate, const Cone *beyond, double distance);

// query_walk.c: the walk without trees.
void query_walk(VisQuery *q, int cell);

// query_cell.c: marks what of a cell's objects the cone meets.
void query_draw_cell(VisQuery *q, int cell, const Cone *cone);
void query_list_objects(VisQuery *q, Arena *arena);  // before all queries
static inline bool query_lists_objects(const VisQuery *q, int cell) { return q->of_cell[cell].box_count > 0; }
// No corner of the box is in front of one of the planes: it cannot be seen.
bool query_box_outside(Box box, const Plane *planes, int count, Vec3 eye);

#endif
