// polygon.h - the one polygon clipper, and what else is asked of single polygons.
#ifndef CORE_POLYGON_H
#define CORE_POLYGON_H

#include "engine/core/vec.h"

// Keeps the part of a convex polygon with plane_distance >= -slack (metres). Returns the vertex count, 0 when
// nothing is left; `out` needs room for count + 1 vertices and may not be `in`. A cut vertex depends on the edge
// alone, not on its direction, so that two polygons that share an edge share the cut.
int polygon_clip(const Vec3 *in, int count, Plane keep, double slack, Vec3 *out);

// Cuts a convex polygon (collinear vertices allowed) into count - 2 triangles of its own vertices, preferring
// fat ones; degenerate triangles arise only where nothing else is possible. `triangle` [3 * (count - 2)].
void polygon_triangulate(const Vec3 *vertices, int count, int *triangle);

// Below this sine of the corner angle a vertex counts as collinear; models hold six digits at best.
#define POLYGON_COLLINEAR 1e-6
// The sine of the turn from a -> b to b -> c about n; 0 where two points coincide.
double polygon_corner_sine(Vec3 a, Vec3 b, Vec3 c, Vec3 n);
// How far the farthest vertex lies off the plane, metres.
double polygon_bend(const Vec3 *vertices, int count, Plane plane);
// No corner turns right about n (within POLYGON_COLLINEAR), and the corners together turn once.
bool polygon_is_convex(const Vec3 *vertices, int count, Vec3 n);

#endif
