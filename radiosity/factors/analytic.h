// analytic.h - form factors in closed form: of polygons from a point, of pairs of polygons, and of the parts of a polygon
// that other polygons leave in sight.
#ifndef RADIOSITY_ANALYTIC_H
#define RADIOSITY_ANALYTIC_H

#include "radiosity/factors/form_factor.h"

// The most corners that a polygon may have.
#define ANALYTIC_CORNERS 512

// The share of the light that leaves the origin, about the normal z, that meets a convex polygon (either way round)
// with nothing between. The part of the polygon below the horizon (z < 0) counts as 0.
double analytic_point(const Vec3 *polygon, int count);

// An occluder: the cone over a convex polygon seen from the origin, from the polygon's plane on.
typedef struct AnalyticOccluder {
    Plane beyond;       // the hidden space is on its positive side, behind the polygon
    const Plane *edge;  // [edge_count] planes through the origin; the cone is on their positive sides
    int edge_count;
    int rank;  // of polygons in one plane, the one of lower rank is seen
} AnalyticOccluder;

// Makes the occluder of a convex polygon, either way round; `edge` has room for `count` planes. False where the polygon has no
// cone: it has no area, or the origin is in its plane.
bool analytic_occluder(const Vec3 *polygon, int count, int rank, Plane *edge, AnalyticOccluder *out);

// Calls `piece` with each convex part of a convex polygon that the occluders leave in sight of the origin. `rank` as in
// AnalyticOccluder; an occluder of the same rank is the polygon itself and hides nothing. Returns how many cuts were made.
long long analytic_visible(const Vec3 *polygon, int count, int rank, const AnalyticOccluder *occluder,
                           int occluder_count, void (*piece)(void *context, const Vec3 *polygon, int count),
                           void *context);
// The same where only the occluders `which` [which_count], ascending, may hide any of the polygon: all others are in other directions.
long long analytic_visible_among(const Vec3 *polygon, int count, int rank, const AnalyticOccluder *occluder,
                                 const int *which, int which_count,
                                 void (*piece)(void *context, const Vec3 *polygon, int count), void *context);
// The part of a polygon in sight of the origin, piece after piece: the share of light from the origin, about z, that meets it; its area,
// m^2; and its middle times its area.
typedef struct AnalyticSight {
    double share, area;
    Vec3 moment;
} AnalyticSight;
// Adds a piece to an AnalyticSight, for analytic_visible. The sum does not depend on how the part is cut into pieces, but for rounding.
void analytic_sight_add(void *sight, const Vec3 *polygon, int count);
// The sum of analytic_point over the parts that analytic_visible finds.
double analytic_point_visible(const Vec3 *polygon, int count, const AnalyticOccluder *occluder,
                              int occluder_count);

// Area of a times the form factor from convex polygon a to convex polygon b, m^2; exchanging a and b gives the same result to
// the last bit. Both are counter-clockwise seen from their fronts, and nothing is between them.
double analytic_exchange(const Vec3 *a, int a_count, const Vec3 *b, int b_count);

#endif
