// curved.h - curved shapes of a building: exact where rays are traced, polygons everywhere else.
//
// A shape's polygons are ordinary polygons of its object, within `tolerance` of the shape; code that draws the shape
// exactly leaves them out. Lengths are metres, in the building's own frame.
#ifndef MAPS_CURVED_H
#define MAPS_CURVED_H

#include "engine/core/vec.h"

typedef enum CurvedKind {
    CURVED_SPHERE,     // all points of length 1; an ellipsoid where the frame's axes differ
    CURVED_CYLINDER,   // x^2 + y^2 = 1, 0 <= z <= 1, and its ends
    CURVED_CONE,       // the same, its radius 1 at z = 0 and `top` at z = 1
    CURVED_PATCH,      // a rational bicubic Bezier patch, perhaps trimmed
    CURVED_METABALLS,  // where the sum of the balls' fields is `threshold`
    CURVED_KINDS
} CurvedKind;

// From a shape's own space to the building: p becomes origin + p.x axis[0] + p.y axis[1] + p.z axis[2]. The axes are
// perpendicular to each other and of any length above 0, left-handed where a model is mirrored.
typedef struct CurvedFrame {
    Vec3 origin, axis[3];
} CurvedFrame;

// A control of a patch, in the building: the point itself, not multiplied by its weight, which is above 0.
typedef struct CurvedControl {
    Vec3 point;
    double weight;
} CurvedControl;

// A rational cubic Bezier curve in the patch's parameters, 0 .. 1 each. The curves of a patch form closed loops, one loop
// after the other: each curve ends where the next begins, the last curve of a loop where the loop's first curve begins. A
// point of the patch exists where the loops wind around it an odd number of times.
typedef struct CurvedTrim {
    Vec2 point[4];
    double weight[4];
} CurvedTrim;

// A ball whose field at distance r is weight * (1 - 22/9 u + 17/9 u^2 - 4/9 u^3) with u = (r / radius)^2, and 0 beyond the
// radius (Wyvill, McPheeters & Wyvill 1986; Nishita & Nakamae 1994).
typedef struct CurvedBall {
    Vec3 centre;
    double radius, weight;  // a weight below 0 takes away
} CurvedBall;

// One shape and the polygons that stand for it.
typedef struct CurvedShape {
    CurvedKind kind;
    int object, material;
    CurvedFrame frame;                 // of all but patches and metaballs
    double top;                        // of a cone: its radius at z = 1, 0 .. 1
    bool disc[2];                      // cylinders and cones: there is a disc at z = 0, at z = 1
    int first_control;                 // of a patch: 16 of Building.controls, four rows along v, u fastest
    int first_trim, trim_count;        // in Building.trims; 0: the whole patch exists
    int first_ball, ball_count;        // in Building.balls
    double threshold;                  // of metaballs, above 0
    double tolerance;                  // how far its polygons may lie off the shape
    int first_polygon, polygon_count;  // in Building.polygons
} CurvedShape;

#endif
