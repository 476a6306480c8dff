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

#endif
