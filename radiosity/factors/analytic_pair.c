// analytic_pair.c - the exchange area of two polygons by their boundaries: 1/(2 pi) of the double contour integral of
// ln r dr . dr' (Sparrow 1963; Goral, Torrance, Greenberg & Battaile 1984).
//
// The inner integral along an edge is done in closed form, the outer integral by adaptive Gauss quadrature. Taking the mean of the
// two orders of integration makes the result symmetric. Schroeder & Hanrahan's closed form of the outer integral, by dilogarithms,
// is not used.

#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "radiosity/factors/analytic.h"

// Halving stops where it changes the integral along an edge by less than PAIR_TOLERANCE, m^2 for edges of metres, and at depth
// PAIR_DEPTH, where even the logarithm's singularity contributes less than the tolerance.
#define PAIR_TOLERANCE 1e-13
enum { PAIR_DEPTH = 40 };

// An edge (`from`, `along`) and the other edge (`to_from`, `to_unit`, `to_length`).
typedef struct EdgePair {
    Vec3 from, along, to_from, to_unit;  // `along` has the edge's length; `to_unit` is unit
    double to_length;
} EdgePair;

// Integral of ln sqrt(h^2 + t^2) over t from 0.
static double log_integral(double t, double h) {
    double square = h * h + t * t;
    if (square == 0) return 0;
    return 0.5 * t * log(square) - t + (h > 0 ? h * atan2(t, h) : 0);
}

// Integral of ln r along the other edge, for the point at share s, 0 .. 1, of the first edge.
static double inner(const EdgePair *e, double s) {
    Vec3 p = vec3_sub(vec3_add(e->from, vec3_scale(e->along, s)), e->to_from);
    double foot = vec3_dot(p, e->to_unit), h = vec3_length(vec3_sub(p, vec3_scale(e->to_unit, foot)));
    return log_integral(e->to_length - foot, h) - log_integral(-foot, h);
}

// Gauss-Legendre of five points.
static double gauss(const EdgePair *e, double a, double b) {
    static const double x[5] = {-0.90617984593866399, -0.53846931010568309, 0, 0.53846931010568309,
                                0.90617984593866399};
    static const double w[5] = {0.23692688505618909, 0.47862867049936647, 0.56888888888888889,
                                0.47862867049936647, 0.23692688505618909};
    double sum = 0;
    for (int i = 0; i < 5; i++) sum += w[i] * inner(e, (a + b) / 2 + (b - a) / 2 * x[i]);
    return sum * (b - a) / 2;
}

static double integrate_halves(const EdgePair *e, double a, double b, double whole, int depth) {
    double m = (a + b) / 2, left = gauss(e, a, m), right = gauss(e, m, b);
    if (depth == PAIR_DEPTH || fabs(left + right - whole) < PAIR_TOLERANCE) return left + right;
    return integrate_halves(e, a, m, left, depth + 1) + integrate_halves(e, m, b, right, depth + 1);
}

// Integral of ln r dr . dr' over two edges; the first is the outer integral.
static double edges(Vec3 a, Vec3 a1, Vec3 b, Vec3 b1) {
    Vec3 along = vec3_sub(a1, a), other = vec3_sub(b1, b);
    double length = vec3_length(other);
    if (length == 0) return 0;
    EdgePair e = {a, along, b, vec3_scale(other, 1 / length), length};
    double turn = vec3_dot(along, e.to_unit);
    return turn == 0 ? 0 : turn * integrate_halves(&e, 0, 1, gauss(&e, 0, 1), 0);
}

// The part of a polygon in front of the plane of the other; `out` has room for count + 1.
static int part_before(const Vec3 *polygon, int count, const Vec3 *other, int other_count, Vec3 *out) {
    Plane plane = plane_of_polygon(other, other_count);
    if (vec3_dot(plane.n, plane.n) == 0) return 0;
    return polygon_clip(polygon, count, plane, 0, out);
}

double analytic_exchange(const Vec3 *a, int a_count, const Vec3 *b, int b_count) {
    CORE_ASSERT(a_count <= ANALYTIC_CORNERS && b_count <= ANALYTIC_CORNERS);
    // The contour integrals ignore fronts, so each polygon is clipped to the part in front of the other's plane.
    Vec3 p[ANALYTIC_CORNERS + 1], q[ANALYTIC_CORNERS + 1];
    int n = part_before(a, a_count, b, b_count, p), m = part_before(b, b_count, a, a_count, q);
    double forth = 0, back = 0;
    if (n < 3 || m < 3) return 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < m; j++) {
            Vec3 p0 = p[i], p1 = p[(i + 1) % n], q0 = q[j], q1 = q[(j + 1) % m];
            forth += edges(p0, p1, q0, q1);
        }
    for (int j = 0; j < m; j++)
        for (int i = 0; i < n; i++) back += edges(q[j], q[(j + 1) % m], p[i], p[(i + 1) % n]);
    return fmax(0, (forth + back) / (4 * M_PI));
}
