// proxy_merge.h - triangles that lie in one plane become convex polygons.
#ifndef RADIOSITY_PROXY_MERGE_H
#define RADIOSITY_PROXY_MERGE_H

#include "radiosity/mesh/simplify.h"

// Corners in `points`, counter-clockwise.
typedef struct ProxyPolygon {
    int *corner;
    int count, tag;  // count 0: it became part of another
} ProxyPolygon;

// [count], in the arena: of each triangle its polygon.
ProxyPolygon *proxy_merge(const Vec3 *points, const SimplifyTriangle *triangles, int count, Arena *arena);

#endif
