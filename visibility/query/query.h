// query.h - the parts that the files of the query share: the cone that narrows from portal to portal, and the query under way.
#ifndef VISIBILITY_QUERY_H
#define VISIBILITY_QUERY_H

#include "engine/core/lanes.h"
#include "visibility/cells/build.h"

enum { CACHE_LINE = 64 };  // bytes, for memory that is fetched ahead
enum { MAX_PLANES = 24, MAX_CORNERS = 2 * MAX_PLANES + 8 };

// Rasterisers compute in floats: 2e-5 m is half a digit at 300 m from the middle of the building.
#define POSITION_SLACK 2e-5
// They snap to 1/256 of a pixel: 5e-5 covers views down to 100 pixels a radian.
#define ANGLE_SLACK 5e-5
// An eye this near a portal's plane counts as on it: the whole volume passes if it is at the portal itself, and a thin
// wedge along the plane if the portal is seen edge-on from afar. Metres.
#define ON_PLANE 1e-3
// An eye this near a portal on its plane may be in it, metres.
#define AT_PORTAL 1e-2

typedef struct Cone {
    // In plan: directions from `from` counter-clockwise to `to`, less than a half turn; or all around.
    Vec2 from, to;
    // Beyond an upright rectangle the planes are four, and these say the same: the wedge, and from below to above it
    // heights over the plan offset u from the eye, bottom . u - bottom_slack to top . u + top_slack.
    Vec2 bottom, top;
    double bottom_slack, top_slack;
    bool is_slot;  // the planes are made when something asks for them: see query_cone_planes
    bool all_around;
    int count;
    Plane plane[MAX_PLANES];  // all through the eye, but for those of the caller's frustum
} Cone;

// Portals as a cell has them, four at a time, in the order of CellGraph.ways: what most tests need, in four lines of
// the cache. Four doubles, not eight floats: a cell has four or five portals in the mean, so that more lanes would stay
// empty, and the slacks of the query hold for buildings of any size. Way 4 * k + i is lane i of block k. The lanes that a
// cell leaves over are nowhere: d is infinite.
typedef struct WayBlock {
    // The portal's plane, pointing into the cell.
    Four nx, ny, d;
    // Where an upright rectangle begins and ends along (ny, -nx), counter-clockwise around an eye in front of it, and in
    // height. Of any other portal s0 > s1, which marks it, -1 - s1 is its index in VisQuery.sloped, and z0 is the third
    // part of its normal.
    Four s0, s1, z0, z1;
    FourInt cell;    // beyond
    FourInt beyond;  // the first block of that cell, and WAY_DOOR
} WayBlock;
enum { WAY_DOOR = 1 << 30 };  // in WayBlock.beyond: it has a door

// One of them, for steps that take one at a time.
typedef struct ViewWay {
    int portal, cell;  // `cell` lies beyond
    int sloped;        // in VisQuery.sloped; -1: it is an upright rectangle
    Plane plane;       // pointing into the cell
    double ahead;      // how far the eye is before it, metres
} ViewWay;

// A straight line over the foot of an upright portal: its height at a place s along it is at + rise * s.
typedef struct SlotEdge {
    Four at, rise;
} SlotEdge;

static inline SlotEdge query_choose_edge(FourMask mask, SlotEdge yes, SlotEdge no) {
    return (SlotEdge){four_choose(mask, yes.at, no.at), four_choose(mask, yes.rise, no.rise)};
}

// The parts in view of four upright rectangles: from s0 to s1 along each, between two lines. Places are metres from the eye's
// foot in the portal's plane, counter-clockwise around the eye seen from above; heights are from the eye's.
typedef struct Slots {
    Four s0, s1;
    SlotEdge bottom, top;
} Slots;

// How the view goes through a portal.
typedef enum Passage {
    PASSAGE_NONE,  // not at all
    PASSAGE_ALL,   // all of it: the eye is in the portal
    PASSAGE_EDGE,  // in a thin wedge along its plane, of which the eye is part
    PASSAGE_PART   // through its visible part
} Passage;

// The part in view of a portal that is no upright rectangle, or is seen edge-on: a polygon, which lies in the graph or in
// one of the buffers.
typedef struct ViewPart {
    const Vec3 *polygon;
    int count;
    Vec3 middle;      // of the polygon, from the eye
    double distance;  // of the nearest corner from the eye, metres
    Vec3 buffer[2][MAX_CORNERS];
} ViewPart;

// Corners of the visible part of a portal, as the walk without trees keeps it; where a part has more, all of the view passes.
enum { VIEW_CORNERS = 12 };

// A portal that is no upright rectangle: the middle and half the size of the box around it, and the polygon in view.
typedef struct Sloped {
    Vec3 centre, half;
    int count;
    Vec3 v[VIEW_CORNERS];
} Sloped;

// A cell as queries see it.
typedef struct CellView {
    int first_block, block_count;  // in VisQuery.ways
    // The first block in VisQuery.boxes, and the lanes in use; none of a cell that holds many objects.
    int first_box, object_count;
    unsigned frame;    // the last query that saw the cell
    int place;         // in that query, the index in VisQuery.cells
    unsigned undrawn;  // in that query, the objects that the cell has not yet shown, a bit each
} CellView;

struct VisQuery {
    const CellGraph *graph;
    const StabForest *forest;
    int depth;       // of the deepest tree
    Cone *cones;     // [depth + 1] one for each level; the first is the eye's own
    WayBlock *ways;  // [block_count] a cell's own, then the next cell's
    int block_count;
    int *portal_of;           // [4 * block_count]
    int *way_of;              // [2 * portal_count] from cell[0] and from cell[1]
    struct ViewBlock *views;  // [block_count] as ways; see query_walk.c
    unsigned *view_frame;     // [block_count] the last query that wrote them: apart, where it is soon asked
    Sloped *sloped;           // [sloped_count] ways that are no upright rectangles
    int sloped_count;
    uint64_t *queue;  // [4 * block_count] ways to go through, a heap: see query_walk.c
    int queue_count;
    CellView *of_cell;        // [cell_count]
    struct BoxBlock *boxes;   // of cells that hold few; see query_cell.c
    Vec3 middle;              // of the building
    VisibleCell *cells;       // [cell_count]
    VisibleCell *spare;       // [cell_count] for sorting
    uint64_t *drawn;          // bit per object
    uint64_t *drawn_words;    // bit per word of `drawn` that is not 0
    unsigned *object_tested;  // [object_count] the last cone it was tested against
    int *objects;             // [object_count] the result
    struct {
        int polygon_count;
        int plug;          // the opening whose door the object plugs, or -1
    } * traits;            // [object_count]
    uint64_t *every_cell;  // a visible set of all
    uint64_t *joined;      // [words] the visible set of the eye, which begins in these cells
    int *joined_cell;      // [cell_count]
    int joined_count;
    unsigned frame, cone_serial;
    // The query under way:
    const Eye *eye;
    const float *door_open;
    Culling culling;
    const uint64_t *limit;  // only cells of this visible set are entered
    VisResult result;
};

// As the query under way has it.
static inline CellView *query_cell_view(VisQuery *q, int cell) {
    CellView *view = &q->of_cell[cell];
    if (view->frame != q->frame) {
        view->frame = q->frame;
        view->place = -1;
        view->undrawn = (1u << view->object_count) - 1;
    }
    return view;
}

// query_cone.c
void query_first_cone(VisQuery *q, Cone *cone);
// One half-space more, unless the cone is full: one less makes it larger, and nothing is lost.
static inline void cone_add(Cone *cone, Vec3 n, double d) {
    if (cone->count < MAX_PLANES) cone->plane[cone->count++] = (Plane){n, d};
}
// The two upright planes of the plan wedge.
static inline void cone_add_wedge(Cone *cone, Vec3 eye) {
    Vec3 from = vec3(-cone->from.y, cone->from.x, 0), to = vec3(cone->to.y, -cone->to.x, 0);
    cone_add(cone, from, vec3_dot(from, eye));
    cone_add(cone, to, vec3_dot(to, eye));
}
// A plan direction of unit length, turned counter-clockwise (`side` +1) or clockwise (-1) by the slack of what it points
// to, at `length` metres. As good as of unit length.
static inline Vec2 cone_turned(Vec2 direction, int side, double length) {
    double turn = side * (ANGLE_SLACK + POSITION_SLACK / length);
    return vec2(direction.x - turn * direction.y, direction.y + turn * direction.x);
}
// Makes the planes of a cone beyond a slot, if they are not yet made.
void query_cone_planes(Cone *cone, Vec3 eye);
// Finds the part that the cone shows of a portal that is no upright rectangle, or is seen edge-on.
Passage query_clip(const VisQuery *q, Cone *cone, const ViewWay *way, ViewPart *out);
// The cone beyond one that is gone through by a polygon; `parent` is the cone before it.
void query_beyond(const VisQuery *q, Cone *parent, Passage passage, const ViewWay *way, const ViewPart *part,
                  Cone *out);

// query_way.c: before all queries.
void query_list_ways(VisQuery *q, Arena *arena);
// Is the portal an upright rectangle? Then where it begins and ends along it, and in height, is written.
bool query_is_wall(const CellGraph *graph, const Portal *portal, Plane plane, double *s, double *z);
ViewWay query_way(const VisQuery *q, int way);
// Could the eye, a hair's breadth from the portal's plane, be in the portal?
bool query_eye_at_portal(const CellGraph *graph, const Portal *portal, Vec3 eye);

// The parts that a cone shows of a block of ways.
typedef struct Sight {
    Four ahead;       // of the eye before their planes, metres
    unsigned slots;   // lanes of which it shows something: upright rectangles
    unsigned others;  // lanes that query_clip must be asked about
    Slots slot;
} Sight;
// Looks through these lanes; returns those that the eye is before.
unsigned query_sight(const VisQuery *q, const Cone *cone, int block, unsigned lanes, Sight *out);

// Finds the parts that the cone shows of upright rectangles, `ahead` metres before the eye. Returns the lanes of which it shows
// anything.
unsigned query_slots_clip(const Cone *cone, const WayBlock *ways, Vec3 eye, Four ahead, Slots *out);
// The distance of the nearest point from the eye, metres.
Four query_slots_distance(const Slots *slots, Four ahead);
// In which lanes is all of `part` in `slots`? Both are of one block of ways.
unsigned query_slots_hold(const Slots *slots, const Slots *part);
// Slots that hold both.
void query_slots_join(const WayBlock *ways, Vec3 eye, const Slots *a, const Slots *b, Slots *out);
// The cone beyond one of them: in plan only its wedge.
void query_slot_cone(const Slots *slots, const WayBlock *ways, int lane, Vec3 eye, bool plan, Cone *out);

// query_eye.c: the cells in which the view begins, all at once, the eye's own first. Of an eye on a surface, and of given cells, those
// that it is in through portals, to a rasteriser's precision; of others those within a millimetre, through walls too; of an eye in no
// cell (`cell` -1) those close by. Returns how many, or 0 where there are none or too many.
enum { MOST_AROUND = 64 };
int query_eye_cells(const CellGraph *graph, int cell, const Eye *eye, int cells[MOST_AROUND]);

// query_walk.c: the walk without trees. Its memory is taken before all queries, after the ways are listed.
void query_prepare_walk(VisQuery *q, Arena *arena);
void query_walk(VisQuery *q, int cell);

// query_cell.c: does a closed door end the view? Not where the eye is in the leaf itself: then it sees both sides.
bool query_door_closed(const VisQuery *q, int way);
// Lists the cell as seen from `distance` metres and marks those of its objects that the cone meets.
void query_visit_cell(VisQuery *q, int cell, double distance, Cone *cone);
// Goes through a portal with the cone beyond it; false where a closed door ends the view.
bool query_enter(VisQuery *q, int way, Cone *beyond, double distance);
void query_list_objects(VisQuery *q, Arena *arena);  // before all queries
// Fetches the listed boxes of a cell into the cache.
void query_prefetch_boxes(const VisQuery *q, int cell);
static inline bool query_lists_objects(const VisQuery *q, int cell) {
    return q->of_cell[cell].object_count > 0;
}
static inline void query_draw_object(VisQuery *q, int object) {
    __builtin_prefetch(&q->traits[object]);  // which the end of the query asks
    q->drawn[object / 64] |= (uint64_t)1 << (object % 64);
    q->drawn_words[object / 4096] |= (uint64_t)1 << (object / 64 % 64);
}
// No corner of the box is in front of one of the planes: it cannot be seen.
bool query_box_outside(Box box, const Plane *planes, int count, Vec3 eye);

#endif
