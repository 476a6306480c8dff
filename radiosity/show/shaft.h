// shaft.h - which polygons can stand between two convex things: those that meet the convex hull of the two (Haines & Wallace, Shaft
// Culling for Efficient Ray-Traced Radiosity, 1991).
#ifndef RADIOSITY_SHAFT_H
#define RADIOSITY_SHAFT_H

#include "engine/core/vec.h"

// A polygon that reaches no farther than this into a shaft touches it, metres (ANALYTIC_TOUCH in analytic.c).
#define SHAFT_TOUCH 1e-8

enum { SHAFT_PLANES = 32 };

// Planes with the hull on their positive sides: a polygon that lies wholly on the negative side of one of them stands beside the shaft.
// The test is conservative: a polygon beside the shaft may pass it.
typedef struct Shaft {
    Plane keep[SHAFT_PLANES];
    int count;
    int closed;  // the first planes, so many: a polygon in one of them is in the shaft
} Shaft;

// Between two boxes, which may overlap.
Shaft shaft_of_boxes(Box one, Box other);
// Between a convex polygon, whose own plane `from` looks at the box at least partly, and a box.
Shaft shaft_to_box(const Vec3 *polygon, int count, Plane from, Box box);

// May the polygon reach into the shaft?
bool shaft_is_met(const Shaft *shaft, const Vec3 *corner, int count);

// Does a convex polygon in `plane` cut every segment between the two sets of points, and so between their hulls?
bool shaft_is_closed(const Vec3 *corner, int count, Plane plane, const Vec3 *one, int one_count,
                     const Vec3 *other, int other_count);

#endif
