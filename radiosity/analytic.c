// analytic.c - the form factor of a polygon from a point in closed form, sum over its edges of the angle they span
// times the share of their plane's normal along z (Lambert 1760; Cohen & Wallace 1993, eq. 4.9), and of what other
// polygons leave of it in sight, by subtracting their cones.
//
// A cone and the plane it starts from bound a convex piece of space; what is left of a convex polygon outside it is
// again convex pieces, one at most for each bound. So the result is exact but for rounding, also where polygons pass
// through each other.
#include "radiosity/analytic.h"

#include "engine/core/error.h"
#include "engine/core/polygon.h"

// What lies less than this behind a polygon touches it and is not hidden by it, metres: above the noise of coordinates
// 1,000 km from the origin (1e-10), below any sheet worth its name (2e-7).
#define ANALYTIC_TOUCH 1e-8
// Pieces of less area are dropped, m^2: rounding, not geometry.
#define ANALYTIC_SLIVER 1e-16

static double edge_share(Vec3 a, Vec3 b) {
    Vec3 across = vec3_cross(a, b);
    double sine = vec3_length(across);
    return sine > 0 ? atan2(sine, vec3_dot(a, b)) * across.z / sine : 0;
}

double analytic_point(const Vec3 *polygon, int count) {
    CORE_ASSERT(count <= ANALYTIC_CORNERS);
    Vec3 above[ANALYTIC_CORNERS + 1];
    int left = polygon_clip(polygon, count, (Plane){vec3(0, 0, 1), 0}, 0, above);
    double sum = 0;
    for (int i = 0; i < left; i++) sum += edge_share(above[i], above[i + 1 < left ? i + 1 : 0]);
    return fabs(sum) / (2 * M_PI);
}

bool analytic_occluder(const Vec3 *polygon, int count, int rank, Plane *edge, AnalyticOccluder *out) {
    Plane plane = plane_of_polygon(polygon, count);
    if (plane.d == 0) return false;  // no area (n = 0), or the origin on it
    bool towards = plane.d < 0;      // the front
    int kept = 0;
    for (int i = 0; i < count; i++) {
        Vec3 a = polygon[i], b = polygon[i + 1 < count ? i + 1 : 0];
        Vec3 n = vec3_normalize(towards ? vec3_cross(b, a) : vec3_cross(a, b));
        // Vertices on an edge repeat its plane.
        bool same = kept > 0 && vec3_dot(n, edge[kept - 1].n) > 1 - 1e-15;
        if (!same && vec3_dot(n, n) > 0) edge[kept++] = (Plane){n, 0};
    }
    Plane beyond = towards ? (Plane){vec3_scale(plane.n, -1), -plane.d} : plane;
    *out = (AnalyticOccluder){.beyond = beyond, .edge = edge, .edge_count = kept, .rank = rank};
    return kept > 2;
}

typedef struct Subtraction {
    const AnalyticOccluder *occluder;
    int occluder_count, rank;
    AnalyticPiece *piece;
    void *context;
    long long cuts;
} Subtraction;

static bool wholly_outside(const Vec3 *polygon, int count, Plane keep, double slack) {
    for (int i = 0; i < count; i++)
        if (plane_distance(keep, polygon[i]) > slack) return false;
    return true;
}

static bool coplanar(const Vec3 *polygon, int count, Plane plane) {
    for (int i = 0; i < count; i++)
        if (fabs(plane_distance(plane, polygon[i])) > ANALYTIC_TOUCH) return false;
    return true;
}

// Does the occluder hide any of the polygon? `in_plane`: the two lie in one plane.
static bool may_hide(const AnalyticOccluder *o, const Vec3 *polygon, int count, int rank, bool *in_plane) {
    if (o->rank == rank) return false;
    *in_plane = coplanar(polygon, count, o->beyond);
    if (*in_plane ? o->rank > rank : wholly_outside(polygon, count, o->beyond, ANALYTIC_TOUCH)) return false;
    for (int e = 0; e < o->edge_count; e++)
        if (wholly_outside(polygon, count, o->edge[e], 0)) return false;
    return true;
}

static void subtract(Subtraction *s, const Vec3 *polygon, int count, int next);

// Hands on what lies outside `bound`, and leaves in `polygon` what lies inside.
static int split(Subtraction *s, Vec3 *polygon, int count, Plane bound, int next) {
    CORE_ASSERT(count < ANALYTIC_CORNERS);
    Vec3 part[ANALYTIC_CORNERS + 1];
    Plane outside = {vec3_scale(bound.n, -1), -bound.d};
    int left = polygon_clip(polygon, count, outside, 0, part);
    s->cuts++;
    if (left >= 3 && polygon_area(part, left) > ANALYTIC_SLIVER) subtract(s, part, left, next);
    left = polygon_clip(polygon, count, bound, 0, part);
    for (int i = 0; i < left; i++) polygon[i] = part[i];
    return left;
}

// The polygon less occluders `next` on. Depth-first: as deep as occluders that cut it.
static void subtract(Subtraction *s, const Vec3 *polygon, int count, int next) {
    bool in_plane = false;
    while (next < s->occluder_count && !may_hide(&s->occluder[next], polygon, count, s->rank, &in_plane))
        next++;
    if (next == s->occluder_count) {
        s->piece(s->context, polygon, count);
        return;
    }
    const AnalyticOccluder *o = &s->occluder[next];
    Vec3 inside[ANALYTIC_CORNERS + 1];
    for (int i = 0; i < count; i++) inside[i] = polygon[i];
    if (!in_plane) count = split(s, inside, count, o->beyond, next + 1);
    for (int e = 0; e < o->edge_count && count >= 3; e++)
        count = split(s, inside, count, o->edge[e], next + 1);
}

long long analytic_visible(const Vec3 *polygon, int count, int rank, const AnalyticOccluder *occluder,
                           int occluder_count, AnalyticPiece *piece, void *context) {
    CORE_ASSERT(count < ANALYTIC_CORNERS);
    Subtraction s = {occluder, occluder_count, rank, piece, context, 0};
    Vec3 above[ANALYTIC_CORNERS + 1];
    int left = polygon_clip(polygon, count, (Plane){vec3(0, 0, 1), 0}, 0, above);
    if (left >= 3) subtract(&s, above, left, 0);
    return s.cuts;
}

static void add_piece(void *context, const Vec3 *polygon, int count) {
    *(double *)context += analytic_point(polygon, count);
}

double analytic_point_visible(const Vec3 *polygon, int count, const AnalyticOccluder *occluder,
                              int occluder_count) {
    double sum = 0;
    analytic_visible(polygon, count, -1, occluder, occluder_count, add_piece, &sum);
    return sum;
}
