// polygon.h - clipping of convex polygons, tests for points inside rings, and other measures of single polygons.
#ifndef CORE_POLYGON_H
#define CORE_POLYGON_H

#include "engine/core/vec.h"

// Keeps the part of a convex polygon with plane_distance >= -slack (metres). Returns the vertex count, 0 when
// nothing is left; `out` needs room for count + 1 vertices and may not be `in`. A cut vertex depends on the edge
// alone, not on its direction, so that two polygons that share an edge share the cut.
int polygon_clip(const Vec3 *in, int count, Plane keep, double slack, Vec3 *out);

// As polygon_clip, for polygons that are clipped a thousand times, each independently of its neighbours: corners within `slack` of
// the plane count as on the plane and stay where they are, so that no hair-thin edges arise. `distance` [count] is the distance of
// each corner from the plane, in any unit, and `slack` is in the same unit; corners at -slack and more are kept. A cut is computed
// from the edge's first end. `out` needs room for count + 1 vertices.
//
// Two clippers have code of their own: image.c (visibility/hidden) clips homogeneous coordinates, and wad_bsp.c (maps/doom) clips
// lines on a grid.
static inline int polygon_clip_band(const Vec3 *in, const double *distance, int count, double slack,
                                    Vec3 *out) {
    int kept = 0;
    for (int i = 0; i < count; i++) {
        int next = i + 1 == count ? 0 : i + 1;
        double a = distance[i], b = distance[next];
        if (a >= -slack) out[kept++] = in[i];
        bool crosses = (a > slack && b < -slack) || (a < -slack && b > slack);
        if (crosses) out[kept++] = vec3_lerp(in[i], in[next], a / (a - b));
    }
    return kept;
}

// Does the half-line from p towards +x cross the edge from a to b? An edge includes its lower end but not its upper one, and a
// point on an edge counts as to its right, so that p is in exactly one of the rings that share an edge. A point is inside where the
// half-line crosses an odd number of edges of all rings together. The two orders of the formula differ by rounding, and stored
// results depend on either order, so both are kept.
//
// Two tests have code of their own: readers of plans (maps/plan) decide exactly, by orient2d, and loops of trims (maps/curved) use
// the half-line towards -x.
enum { RING_DIVIDE_FIRST, RING_MULTIPLY_FIRST };
static inline bool ring_edge_is_crossed(Vec2 a, Vec2 b, Vec2 p, int order) {
    if ((a.y > p.y) == (b.y > p.y)) return false;
    if (order == RING_DIVIDE_FIRST) return p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x);
    return p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y);
}

// Is the point inside a ring of corners? The ring may be concave and of either orientation. Edges run from each corner to the next.
static inline bool ring_contains(const Vec2 *ring, int count, Vec2 p) {
    bool inside = false;
    for (int i = 0; i < count; i++)
        inside ^= ring_edge_is_crossed(ring[i], ring[i + 1 == count ? 0 : i + 1], p, RING_DIVIDE_FIRST);
    return inside;
}

// Cuts a convex polygon (collinear vertices allowed) into count - 2 triangles of its own vertices, preferring
// fat ones; degenerate triangles arise only where nothing else is possible. `triangle` [3 * (count - 2)].
void polygon_triangulate(const Vec3 *vertices, int count, int *triangle);

// Below this sine of the corner angle a vertex counts as collinear; models hold six digits at best.
#define POLYGON_COLLINEAR 1e-6
// The sine of the turn from a -> b to b -> c about n; 0 where two points coincide.
double polygon_corner_sine(Vec3 a, Vec3 b, Vec3 c, Vec3 n);
// How far the farthest vertex lies off the plane, metres.
double polygon_bend(const Vec3 *vertices, int count, Plane plane);
// Does no corner turn right about n (within POLYGON_COLLINEAR), and do all corners together turn exactly once?
bool polygon_is_convex(const Vec3 *vertices, int count, Vec3 n);

#endif
