// enclose.h - the data that the steps of maps_enclose hand to each other. Private to maps/enclose.
//
// Plan coordinates here are millimetres from a local origin at whole metres, so that a building far from the
// origin is treated as one at the origin; grid points are whole numbers, exact in doubles. Heights are
// absolute millimetres.
#ifndef MAPS_ENCLOSE_H
#define MAPS_ENCLOSE_H

#define GEOS_USE_ONLY_R_API
#include <geos_c.h>

#include "engine/core/box_tree.h"
#include "engine/core/sets.h"
#include "maps/building/sketch.h"

#define ENCLOSE_MM 1000.0  // millimetres in a metre
// The most spots. All storeys share one plan, and each storey has a spot for each face of the plan: storeys times faces. Where the
// outlines make more spots, they are tried again with a smaller share of this number.
#define ENCLOSE_MOST_SPOTS 4000000

// A polygon of any number of rings, even-odd.
typedef struct Shape {
    Vec2 *points;
    int *ring;  // [ring_count + 1] offsets into points
    int ring_count;
    Vec2 min, max;
} Shape;

typedef struct ShapeList {
    Shape *items;
    int count, capacity;
} ShapeList;

// An edge of the arrangement: face[0] lies left of v[0] -> v[1], face[1] right of it; -1: beyond the world.
typedef struct PlanEdge {
    int v[2], face[2];
} PlanEdge;

// Half-edge h is edge h / 2, run from v[h & 1]; its left face is face[h & 1].
typedef struct PlanFace {
    int first_half, half_count;  // in Plan.halves: all of its rings, in no order
    Vec2 inner;                  // a point well inside
    double area, perimeter;      // mm^2, mm
} PlanFace;

// A ring, or an open line, of the linework.
typedef struct Line {
    const Vec2 *points;
    int count;
    bool close;
} Line;

// One planar arrangement of the linework of all storeys.
typedef struct Plan {
    Vec2 *vertices;
    PlanEdge *edges;
    PlanFace *faces;
    int *halves;
    BoxTree inner;  // over the inner points of the faces, as if on storey 0
    int vertex_count, edge_count, face_count, half_count;
} Plan;

// The plan box of an opening, with its depth fitted to the walls.
typedef struct Hole {
    bool used;
    bool walled;        // stands in a wall
    Vec2 centre, u, n;  // mm; width axis and normal, unit
    double half;        // half the width
    double v0, v1;      // reach along n
    double sill, head;
    Vec2 line[2];  // the plane in which a door closes
    Shape box;
    int opening;  // in Building.openings, -1 until appended
} Hole;

// A room's outline, grown by the thickness of its implicit wall.
typedef struct Grown {
    Shape shape;
    int room;
} Grown;

// Spot.wall: the index of a wall, or one of these.
enum { NO_WALL = -1, WALL_IMPLICIT = -2, WALL_PLUG = -3, WALL_CAVITY = -4, WALL_SLIT = -5 };
enum { SPOT_HOLES = 4 };  // openings above one another in one storey's wall

// The wall, openings and room that one storey has at one face.
typedef struct Spot {
    int wall;
    int hole[SPOT_HOLES];  // openings, -1: none
    int room;              // as drawn, -1: none
    int cutout;            // -1: none
    int indoor;   // a room's index, room_count + n for the nth unnamed space, or -1: outdoors or solid
    int terrace;  // the room whose floor lies here under the sky, -1: none
    int owner;    // of an implicit wall: a room that it closes
} Spot;

// A piece of the column over a face.
typedef struct Span {
    enum { SPAN_SOLID, SPAN_ROOM, SPAN_OUTDOORS, SPAN_OPENING, SPAN_SHAFT } kind;
    // ROOM: as Spot.indoor; OUTDOORS: floor material, or material_count + the room of a terrace; OPENING: 2 * hole + side; SHAFT: cut-out.
    int id;
    int storey;
    double z0, z1;
    int region;  // in Building.regions, -1
} Span;

// One attempt at the plan, with or without plugs in small gaps.
typedef struct Pass {
    Plan plan;
    Spot *spots;        // [storey_count * face_count]
    int *space_storey;  // [space_count] of unnamed enclosed spaces
    int space_count, space_capacity;
    int *cover_first, *cover_wall;  // the walls that cover face f, ascending: cover_wall[cover_first[f]] ..
    double enclosed;                // mm^2 indoors
    bool leaking;                   // a room lies open, or walls enclose nothing
} Pass;

typedef struct Enclosure {
    const Sketch *sketch;
    Building *b;
    Arena *arena, *scratch;
    Error *error;
    GEOSContextHandle_t geos;
    char geos_message[256];
    Vec2 origin;  // metres, whole
    Vec2 world_min, world_max;
    double bottom, top;  // of all columns
    double share;        // of ENCLOSE_MOST_SPOTS that outlines may take, 1 at first
    bool too_many;       // there were too many spots: a smaller share may help
    bool changed;        // wall_low changed: the attempt is to be made again
    Shape *walls, *rooms, *cutouts;
    bool *wall_bounds;  // [wall_count] is usable, and reaches the ceiling or counts as if it did
    bool *
        wall_low;  // [wall_count] is lower than its storey and bounds nothing; found in the first attempt, true in all later ones
    bool settled;  // no later attempt will change wall_low
    bool *room_used, *cutout_used;
    double *room_wall;    // [room_count] mm of implicit wall, 0: none
    Grown *grown;         // [grown_count] implicit walls: the space in these, less the rooms they surround
    ShapeList *implicit;  // [storey_count] union of the implicit walls
    ShapeList *plugs;     // [storey_count] fillings of small gaps
    ShapeList *slits;     // [storey_count] fillings between openings and the ends of walls beside them
    double widest_slit;   // mm, and the opening beside it
    int slit_opening;
    Hole *holes;  // [opening_count]
    int grown_count, grown_capacity;
    BoxTree wall_tree, room_tree, grown_tree, hole_tree;  // of shapes in use, on their storeys (enclose_box)
    BoxTree side_tree;                                    // of all sides of walls, wall by wall
    int *side_wall, *side_at;                             // [side count] its wall, and its number in the wall
    BoxHits near, faces, sides;                           // last hits in trees above, Plan.inner, side_tree
    // [storey_count] base: under its slab; cover: the top of the roof or slab above.
    double *floor, *ceiling, *base, *cover;
    Pass pass;
    int *hole_first, *hole_faces;  // the faces of opening i: hole_faces[hole_first[i]] ..
    Span *spans;
    // [face_count + 1] The column over face f: spans[first_span[f]] .. spans[first_span[f + 1] - 1], upwards.
    int *first_span;
    int span_count, span_capacity;
} Enclosure;

static inline const Spot *spot_at(const Enclosure *e, int storey, int face) {
    return &e->pass.spots[(size_t)storey * (size_t)e->pass.plan.face_count + (size_t)face];
}

// A plan rectangle on a storey, as the trees hold it.
static inline Box enclose_box(Vec2 min, Vec2 max, int storey) {
    return (Box){vec3(min.x, min.y, storey), vec3(max.x, max.y, storey)};
}
static inline Box enclose_around(Vec2 p, double reach, int storey) {
    return enclose_box(vec2(p.x - reach, p.y - reach), vec2(p.x + reach, p.y + reach), storey);
}

// ---- enclose_plan.c
bool shape_contains(const Shape *shape, Vec2 p);
Shape shape_of_points(Arena *arena, const Vec2 *points, int count);
GEOSGeometry *shape_to_geos(Enclosure *e, const Shape *shape);  // made valid; NULL on failure
void shapes_from_geos(Enclosure *e, const GEOSGeometry *geometry, double narrowest, ShapeList *out);
// Nodes and polygonizes everything in use; false with the error set when GEOS fails.
bool plan_build(Enclosure *e, bool with_plugs, Plan *out);
// The arrangement of the lines on the grid, without inner points (enclose_arrange.c).
void plan_arrange(Enclosure *e, const Line *lines, int count, Plan *out);
// Puts the faces whose inner point lies in the shape into e->faces, ascending. Returns how many.
int plan_faces_in(Enclosure *e, const Plan *p, const Shape *shape);
static inline int half_from(const Plan *p, int h) { return p->edges[h >> 1].v[h & 1]; }
static inline int half_to(const Plan *p, int h) { return p->edges[h >> 1].v[~h & 1]; }
static inline int half_left(const Plan *p, int h) { return p->edges[h >> 1].face[h & 1]; }
static inline int half_right(const Plan *p, int h) { return p->edges[h >> 1].face[~h & 1]; }
static inline double half_length(const Plan *p, int h) {
    return vec2_length(vec2_sub(p->vertices[half_to(p, h)], p->vertices[half_from(p, h)]));
}

// ---- enclose_input.c
bool enclose_prepare(Enclosure *e);  // shapes, heights, low walls; false with the error set
// Call once crossings are limited: builds the trees of walls and rooms, and finds the world's box.
bool enclose_find_world(Enclosure *e);
bool enclose_implicit_walls(Enclosure *e);  // around rooms of plans without walls
bool enclose_plugs(Enclosure *e, bool *any);
Vec2 enclose_local(const Enclosure *e, Vec2 p);   // metres to local millimetres
Vec2 enclose_metres(const Enclosure *e, Vec2 p);  // and back: a grid point becomes the value of maps_snap
Vec3 enclose_place(const Enclosure *e, Vec2 p, int storey);
const char *enclose_text(const char *place);

// Adds a wall to the building as an object, among the furniture.
void enclose_add_low_wall(Enclosure *e, int wall);
// Counts the area of a room as drawn and as lost.
void enclose_lose_room(Enclosure *e, int room);

// ---- enclose_crossings.c
void crossings_limit(Enclosure *e);        // of rooms, cut-outs and walls, once they are known
void crossings_limit_holes(Enclosure *e);  // of openings, once they are fitted

// ---- enclose_holes.c
void holes_fit(Enclosure *e);
// Whether a wall or an opening stands at a place of the storey. Call once the openings are fitted.
bool holes_wall_at(Enclosure *e, int storey, Vec2 p);
// Closes slits beside openings: fills e->slits.
void holes_close_slits(Enclosure *e);

// ---- enclose_cover.c
void cover_label(Enclosure *e, Pass *pass, bool with_plugs);  // makes pass->spots

// ---- enclose_indoor.c
void indoor_label(Enclosure *e, Pass *pass);
// Whether the face has neither a wall nor an opening on the storey.
static inline bool spot_is_open(const Spot *s) { return s->wall == NO_WALL && s->hole[0] < 0; }
// Mean width of a face or patch.
static inline double face_width(double area, double perimeter) {
    return perimeter > 0 ? 2 * area / perimeter : 0;
}

// ---- enclose_low.c
// Whether a wall lower than its storey is high enough to bound rooms, and was not found to bound none.
bool enclose_may_bound(const Enclosure *e, int wall);
// Finds in e->pass which walls lower than their storey bound nothing, and marks them in e->wall_low. Returns whether there are any.
bool enclose_settle_low_walls(Enclosure *e);

// ---- enclose_report.c
void indoor_report(Enclosure *e);  // areas, terraces, openings that lie over one another, closed gaps
void leaks_report(Enclosure *e);   // the way from each open room to the hole and out

// ---- enclose_columns.c
// The first of `count` spans of a column that ends above a height.
static inline int span_above(const Span *spans, int count, double z) {
    int low = 0, high = count;
    while (low < high) {
        int middle = (low + high) / 2;
        if (spans[middle].z1 > z)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}
// The same of the column over a face, in e->spans; the column's end where there is none.
static inline int face_span_above(const Enclosure *e, int face, double z) {
    int first = e->first_span[face];
    return first + span_above(e->spans + first, e->first_span[face + 1] - first, z);
}
void columns_build(Enclosure *e);
void columns_drop_unseen_outdoors(Enclosure *e);
static inline bool span_equal(const Span *a, const Span *b) {
    return a->kind == b->kind && a->id == b->id && a->z0 == b->z0 && a->z1 == b->z1;
}

// ---- enclose_regions.c
void regions_trace(Enclosure *e);
void enclose_push_point(Enclosure *e, Vec2 metres, int material);

// ---- enclose_openings.c
void openings_append(Enclosure *e);  // call before the regions, which refer to the openings
void openings_join(Enclosure *e);    // finds the regions on either side; draws leaves and spandrels

// ---- enclose_start.c
void enclose_choose_start(Enclosure *e);

#endif
