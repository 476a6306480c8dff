// body.h - the body of a walking person: an upright cylinder that climbs stairs, ducks and falls, and that walls, furniture and
// doors stop.
//
// At rest no solid is within BODY_RADIUS of the body's axis between its foot and its height. The body changes cells only through
// portals.
#ifndef WALK_BODY_H
#define WALK_BODY_H

#include "engine/sim/obstacles.h"

// Metres. Shoulders are broader, but a person turns them in a doorway.
#define BODY_RADIUS 0.2
#define BODY_HEIGHT 1.7
// The height to which the body ducks by itself, for cellar doors and attics.
#define BODY_LOWEST 1.2
// The highest step: higher than a door's sill of 0.3, lower than a coffee table's 0.4.
#define BODY_STEP 0.39
// The height of the eye of a standing person, and the least distance of the eye from a solid overhead, metres.
#define BODY_EYE 1.6
#define BODY_CROWN 0.1
// A solid over the middle of the body, within this radius, is over its head; metres.
#define BODY_HEAD 0.1
// The body's cell is the cell of its axis at this height over the foot: the middle of the heights that the body may neither step
// over nor duck under, so that this point never lies in a sill or lintel that the body passes.
#define BODY_MIDDLE ((BODY_STEP + BODY_LOWEST) / 2)
// Rounding may bring the body nearer to a solid than its radius by this much, metres.
#define BODY_TOLERANCE 1e-6

// A person as an upright cylinder of radius BODY_RADIUS. A plain value: one thread at a time moves a body, and a copy is a body of
// its own.
typedef struct Body {
    Vec3 foot;      // where the axis meets the solid that the body stands on
    double height;  // from the foot up, metres, as low as the body ducks here
    double head;    // from the foot up to the solid over the middle: a picture on the wall lowers no head
    double fall;    // speed downwards, m/s
    bool standing;
    int cell;  // see BODY_MIDDLE; -1 before it is placed
} Body;

// The corners of the path of a foot, for code that checks the path. The caller owns the points.
typedef struct BodyTrace {
    Vec3 *points;  // [capacity]
    int count, capacity;
    bool overflow;
} BodyTrace;

// The solids and doors among which bodies walk, and counts of the work. Only one thread at a time may use a BodyWorld, for any
// number of bodies. It lives in the arena of body_world and may take more from it: the arena must stay in its place and belong to that
// thread. The graph, `door_open` and `trace` are the caller's and must outlive it.
typedef struct BodyWorld {
    const CellGraph *graph;
    Obstacles *obstacles;
    const float *door_open;  // as for vis_query, the caller's
    BodyTrace *trace;        // or NULL
    long wall_tests, object_tests, pieces;
    long relocations;  // bodies found in a solid and put elsewhere
    long refused;      // pieces of a way given up because rounding would have led into a solid
} BodyWorld;
BodyWorld body_world(const CellGraph *graph, const float *door_open, Arena *arena);

// Puts the body on the floor at the free place nearest to `foot`, in the same room if the room has one. Returns false and changes
// nothing when there is no free place within BODY_SEARCH metres.
#define BODY_SEARCH 6.0
bool body_place_near(Body *body, BodyWorld *world, Vec3 foot);

// Puts the body on the floor at this place in plan, at most a step above `foot` or on the first solid below it. Returns false and
// changes nothing where there is no room.
bool body_place_at(Body *body, BodyWorld *world, Vec3 foot);

// The body goes `way` in plan, slides along solids that obstruct it, and falls for `seconds` where no solid carries it. Any
// length and any time are safe.
void body_step(Body *body, BodyWorld *world, Vec2 way, double seconds);

// The height of the eye over the foot, metres; a solid overhead lowers the eye at once.
static inline double body_eye(const Body *body) { return fmin(BODY_EYE, body->head - BODY_CROWN); }

#endif
