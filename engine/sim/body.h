// body.h - whoever walks: an upright cylinder that walls, furniture and doors stop, that climbs stairs, ducks and falls.
//
// At rest nothing solid is within BODY_RADIUS of its axis between its foot and its height. It changes cell through
// portals alone.
#ifndef WALK_BODY_H
#define WALK_BODY_H

#include "engine/sim/obstacles.h"

// Metres. Shoulders are broader, but a person turns them in a doorway.
#define BODY_RADIUS 0.2
#define BODY_HEIGHT 1.7
// How low it ducks by itself: cellar doors, attics.
#define BODY_LOWEST 1.2
// The highest step: over a door's sill of 0.3, under a coffee table's 0.4.
#define BODY_STEP 0.39
// The height of the eye of a standing person, and the least distance of the eye from a solid overhead, metres.
#define BODY_EYE 1.6
#define BODY_CROWN 0.1
// A solid over the middle of the body, within this radius, is over its head; metres.
#define BODY_HEAD 0.1
// The body's cell is the cell of its axis at this height over the foot: the middle of the heights that it may neither step
// over nor duck under, so no sill and no lintel that it passes is ever between.
#define BODY_MIDDLE ((BODY_STEP + BODY_LOWEST) / 2)
// How much nearer than its radius rounding may bring it, metres.
#define BODY_TOLERANCE 1e-6

// A person as a capsule of plan radius BODY_RADIUS. A plain value: one thread moves it, copies are bodies of their own.
typedef struct Body {
    Vec3 foot;      // where the axis meets the solid that the body stands on
    double height;  // from there up, as low as it ducks here
    double head;    // from there up to the solid over its middle: a picture on the wall lowers no head
    double fall;    // speed downwards, m/s
    bool standing;
    int cell;  // see BODY_MIDDLE; -1 before it is placed
} Body;

// The corners of the way of a foot, for those who check it.
// The caller owns the points.
typedef struct BodyTrace {
    Vec3 *points;  // [capacity]
    int count, capacity;
    bool overflow;
} BodyTrace;

// The solids and doors among which bodies walk, and counts of the work.
// One thread's at a time, for any number of bodies. It lives in the arena of body_world; the graph, `door_open` and `trace` are the
// caller's and outlive it.
typedef struct BodyWorld {
    const CellGraph *graph;
    Obstacles *obstacles;
    const float *door_open;  // as for vis_query, the caller's
    BodyTrace *trace;        // or NULL
    long wall_tests, object_tests, pieces;
    long relocations;  // found in something solid, and put elsewhere
    long refused;      // pieces of a way given up because rounding would have led into something solid
} BodyWorld;
// Allocates all memory that walking needs.
BodyWorld body_world(const CellGraph *graph, const float *door_open, Arena *arena);

// Puts it on the floor at the free place nearest to `foot`, in the same room if there is one. False, and nothing
// changes, when there is none within BODY_SEARCH.
#define BODY_SEARCH 6.0
bool body_place_near(Body *body, BodyWorld *world, Vec3 foot);

// The body goes `way` in plan, slides along solids that obstruct it, and falls for `seconds` where no solid carries it. Any
// length and any time are safe.
void body_step(Body *body, BodyWorld *world, Vec2 way, double seconds);

// The height of the eye over the foot, metres: it follows a solid overhead at once.
static inline double body_eye(const Body *body) { return fmin(BODY_EYE, body->head - BODY_CROWN); }

#endif
