// analytic.h - form factors in closed form: of polygons from a point, of pairs of polygons, and of what of a polygon
// others leave in sight.
#ifndef RADIOSITY_ANALYTIC_H
#define RADIOSITY_ANALYTIC_H

#include "radiosity/factors/form_factor.h"

// Polygons of more corners are not taken.
#define ANALYTIC_CORNERS 512

// The share of the light that leaves the origin, about the normal z, that meets a convex polygon (either way round)
// with nothing between. The part below the horizon counts nothing.
double analytic_point(const Vec3 *polygon, int count);

// An occluder: the cone over a convex polygon seen from the origin, from the polygon's plane on.
typedef struct AnalyticOccluder {
    Plane beyond;       // keep: the side behind the polygon
    const Plane *edge;  // [edge_count] keep: inside; through the origin
    int edge_count;
    int rank;  // of polygons in one plane the lower one is seen
} AnalyticOccluder;

// Occluder of a convex polygon, either way round; `edge` has room for `count`. False where it has no cone: no area, or
// the origin in its plane.
bool analytic_occluder(const Vec3 *polygon, int count, int rank, Plane *edge, AnalyticOccluder *out);

// Hands `piece` the convex parts that the occluders leave of a convex polygon, seen from the origin. `rank` as in AnalyticOccluder;
// occluders of the same rank are the polygon itself and hide nothing. Returns how many cuts were made.
long long analytic_visible(const Vec3 *polygon, int count, int rank, const AnalyticOccluder *occluder,
                           int occluder_count, void (*piece)(void *context, const Vec3 *polygon, int count),
                           void *context);
// The same, summed.
double analytic_point_visible(const Vec3 *polygon, int count, const AnalyticOccluder *occluder,
                              int occluder_count);

// Area of a times the form factor from convex polygon a to convex polygon b, which is the same the other way round to
// the last bit; both counter-clockwise seen from their fronts, nothing between them.
double analytic_exchange(const Vec3 *a, int a_count, const Vec3 *b, int b_count);

#endif
