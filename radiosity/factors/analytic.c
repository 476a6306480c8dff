// analytic.c - the form factor of a polygon from a point in closed form: the sum over its edges of the angle that the edge spans
// times the z of the unit normal of the edge's plane (Lambert 1760; Cohen & Wallace 1993, eq. 4.9). Where other polygons hide parts
// of the polygon, their cones are subtracted first.
//
// A cone and the plane that it starts from bound a convex piece of space; the rest of a convex polygon outside this piece is
// again convex pieces, at most one for each bound. The result is therefore exact but for rounding, also where polygons pass
// through each other.
#include "radiosity/factors/analytic.h"

#include <string.h>

#include "engine/core/error.h"
#include "engine/core/memory.h"
#include "engine/core/polygon.h"

// A part that lies less than this behind a polygon touches the polygon and is not hidden by it, metres: above the noise of
// coordinates 1,000 km from the origin (1e-10), below the thickness of any sheet (2e-7).
#define ANALYTIC_TOUCH 1e-8
// Pieces of less area than this are rounding and are dropped, m^2.
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

// A piece that the occluders from `next` on may still cut, with corners first .. first + count - 1 of the stack.
typedef struct Waiting {
    int first, count, next;
    int left;  // corners that stay on the stack when the piece is taken
} Waiting;

// The subtraction is depth-first, with a stack of its own: thousands of lamps or leaves may each cut the pieces that the others
// left, and recursion could overflow the machine's stack. The stack for most views fits in the struct.
typedef struct Subtraction {
    const AnalyticOccluder *occluder;
    const int *which;  // [occluder_count] NULL: the first ones
    int occluder_count, rank;
    void (*piece)(void *context, const Vec3 *polygon, int count);
    void *context;
    long long cuts;
    Vec3 *corner;
    Waiting *waiting;
    int corner_count, corner_capacity, waiting_count, waiting_capacity;
    Vec3 few_corners[512];
    Waiting few[64];
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

// Returns the array, which may be the fixed array `few`, with room for `needed` entries.
static void *grown(void *array, const void *few, size_t size, int used, int needed, int *capacity) {
    if (needed <= *capacity) return array;
    while (*capacity < needed) *capacity *= 2;
    void *larger = memory_grow(array == few ? NULL : array, (size_t)*capacity * size);
    return array == few ? memcpy(larger, few, (size_t)used * size) : larger;
}

static void keep_waiting(Subtraction *s, const Vec3 *polygon, int count, int next) {
    int corners = s->corner_count + count, waiting = s->waiting_count + 1;
    s->corner =
        grown(s->corner, s->few_corners, sizeof *s->corner, s->corner_count, corners, &s->corner_capacity);
    s->waiting =
        grown(s->waiting, s->few, sizeof *s->waiting, s->waiting_count, waiting, &s->waiting_capacity);
    memcpy(s->corner + s->corner_count, polygon, (size_t)count * sizeof *polygon);
    s->waiting[s->waiting_count++] = (Waiting){s->corner_count, count, next, corners};
    s->corner_count = corners;
}

// Puts the part of the polygon outside `bound` on the stack and leaves the part inside in `polygon`. Returns the corners inside.
static int split(Subtraction *s, Vec3 *polygon, int count, Plane bound, int next) {
    CORE_ASSERT(count < ANALYTIC_CORNERS);
    Vec3 part[ANALYTIC_CORNERS + 1];
    Plane outside = {vec3_scale(bound.n, -1), -bound.d};
    int left = polygon_clip(polygon, count, outside, 0, part);
    s->cuts++;
    if (left >= 3 && polygon_area(part, left) > ANALYTIC_SLIVER) keep_waiting(s, part, left, next);
    left = polygon_clip(polygon, count, bound, 0, part);
    for (int i = 0; i < left; i++) polygon[i] = part[i];
    return left;
}

// Reverses the waiting pieces from `first` on, so that they are taken in the order in which they came; taking the last of them
// frees the corners of all.
static void turn_round(Subtraction *s, int first, int corners) {
    for (int a = first, b = s->waiting_count - 1; a < b; a++, b--) {
        Waiting swapped = s->waiting[a];
        s->waiting[a] = s->waiting[b];
        s->waiting[b] = swapped;
    }
    for (int i = first; i < s->waiting_count; i++)
        s->waiting[i].left = i == first ? corners : s->corner_count;
}

static const AnalyticOccluder *occluder_at(const Subtraction *s, int i) {
    return &s->occluder[s->which ? s->which[i] : i];
}

// Takes the top piece of the stack: the first occluder that hides any part of the piece cuts it; if there is none, the piece is
// visible and `piece` is called.
static void subtract(Subtraction *s) {
    Waiting taken = s->waiting[--s->waiting_count];
    Vec3 inside[ANALYTIC_CORNERS + 1];
    memcpy(inside, s->corner + taken.first, (size_t)taken.count * sizeof *inside);
    s->corner_count = taken.left;
    bool in_plane = false;
    int next = taken.next, count = taken.count, first = s->waiting_count, corners = s->corner_count;
    while (next < s->occluder_count && !may_hide(occluder_at(s, next), inside, count, s->rank, &in_plane))
        next++;
    if (next == s->occluder_count) {
        s->piece(s->context, inside, count);
        return;
    }
    const AnalyticOccluder *o = occluder_at(s, next);
    if (!in_plane) count = split(s, inside, count, o->beyond, next + 1);
    for (int e = 0; e < o->edge_count && count >= 3; e++)
        count = split(s, inside, count, o->edge[e], next + 1);
    turn_round(s, first, corners);
}

long long analytic_visible_among(const Vec3 *polygon, int count, int rank, const AnalyticOccluder *occluder,
                                 const int *which, int which_count,
                                 void (*piece)(void *context, const Vec3 *polygon, int count),
                                 void *context) {
    CORE_ASSERT(count < ANALYTIC_CORNERS);
    Subtraction s;
    s.occluder = occluder, s.which = which, s.occluder_count = which_count, s.rank = rank;
    s.piece = piece, s.context = context, s.cuts = 0;
    s.corner = s.few_corners, s.corner_count = 0,
    s.corner_capacity = sizeof s.few_corners / sizeof *s.few_corners;
    s.waiting = s.few, s.waiting_count = 0, s.waiting_capacity = sizeof s.few / sizeof *s.few;
    Vec3 above[ANALYTIC_CORNERS + 1];
    int left = polygon_clip(polygon, count, (Plane){vec3(0, 0, 1), 0}, 0, above);
    if (left >= 3) keep_waiting(&s, above, left, 0);
    while (s.waiting_count > 0) subtract(&s);
    if (s.corner != s.few_corners) memory_free(s.corner);
    if (s.waiting != s.few) memory_free(s.waiting);
    return s.cuts;
}

long long analytic_visible(const Vec3 *polygon, int count, int rank, const AnalyticOccluder *occluder,
                           int occluder_count, void (*piece)(void *context, const Vec3 *polygon, int count),
                           void *context) {
    return analytic_visible_among(polygon, count, rank, occluder, NULL, occluder_count, piece, context);
}

void analytic_sight_add(void *context, const Vec3 *polygon, int count) {
    AnalyticSight *sight = context;
    sight->share += analytic_point(polygon, count);
    for (int i = 1; i + 1 < count; i++) {
        Vec3 a = polygon[0], b = polygon[i], c = polygon[i + 1];
        double area = vec3_length(vec3_cross(vec3_sub(b, a), vec3_sub(c, a))) / 2;
        sight->area += area;
        sight->moment = vec3_add(sight->moment, vec3_scale(vec3_add(a, vec3_add(b, c)), area / 3));
    }
}

static void add_visible_piece(void *context, const Vec3 *polygon, int count) {
    *(double *)context += analytic_point(polygon, count);
}

double analytic_point_visible(const Vec3 *polygon, int count, const AnalyticOccluder *occluder,
                              int occluder_count) {
    double sum = 0;
    analytic_visible(polygon, count, -1, occluder, occluder_count, add_visible_piece, &sum);
    return sum;
}
