// vec.c - the plane and the area of a polygon by Newell's sum over its edges; the orientation of three points, exactly.
//
// Source of the orientation test: J. R. Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
// Predicates, 1997: the static filter of its section 4.3 and, where the filter cannot decide, the sum of the six products ax*by,
// ... as a non-overlapping expansion (its sections 2.2 to 2.5). There is only one stage in between, for points on a grid.
#include "engine/core/vec.h"

#include <float.h>

static Vec3 newell(const Vec3 *v, int count) {
    Vec3 sum = {0, 0, 0};
    // Vertices are taken relative to the first one, so that a building far from the origin does not lose its digits.
    for (int i = 1; i + 1 < count; i++) {
        sum = vec3_add(sum, vec3_cross(vec3_sub(v[i], v[0]), vec3_sub(v[i + 1], v[0])));
    }
    return sum;
}

Plane plane_of_polygon(const Vec3 *vertices, int count) {
    Vec3 n = vec3_normalize(newell(vertices, count));
    Vec3 offset = {0, 0, 0};
    for (int i = 1; i < count; i++) offset = vec3_add(offset, vec3_sub(vertices[i], vertices[0]));
    Vec3 centre = count > 0 ? vec3_add(vertices[0], vec3_scale(offset, 1.0 / count)) : vec3(0, 0, 0);
    return (Plane){n, vec3_dot(n, centre)};
}

double polygon_area(const Vec3 *vertices, int count) { return vec3_length(newell(vertices, count)) / 2; }

// ---- orientation

// Error bound of the first stage: (3 + 16 u) u with u = 2^-53.
static const double FILTER = (3.0 + 8.0 * DBL_EPSILON) * (DBL_EPSILON / 2);

typedef struct Expansion {
    double term[12];  // non-overlapping, increasing in magnitude
    int count;
} Expansion;

// Adds one double to the expansion (Shewchuk's Grow-Expansion with Two-Sum).
static void grow_expansion(Expansion *e, double b) {
    double q = b;
    int kept = 0;
    for (int i = 0; i < e->count; i++) {
        double a = e->term[i], sum = q + a, bb = sum - q;
        double tail = (q - (sum - bb)) + (a - bb);
        q = sum;
        if (tail != 0) e->term[kept++] = tail;
    }
    if (q != 0 || kept == 0) e->term[kept++] = q;
    e->count = kept;
}

static void add_product(Expansion *e, double a, double b) {
    double high = a * b, low = fma(a, b, -high);
    grow_expansion(e, low);
    grow_expansion(e, high);
}

static int orient_exact(Vec2 a, Vec2 b, Vec2 c) {
    Expansion e = {{0}, 0};
    add_product(&e, a.x, b.y);
    add_product(&e, -a.y, b.x);
    add_product(&e, b.x, c.y);
    add_product(&e, -b.y, c.x);
    add_product(&e, c.x, a.y);
    add_product(&e, -c.y, a.x);
    double top = e.term[e.count - 1];
    return (top > 0) - (top < 0);
}

// The rounding error of a - b (Shewchuk's Two-Diff-Tail).
static double difference_tail(double a, double b) {
    double x = a - b, b_virtual = a - x, a_virtual = x + b_virtual;
    return (a - a_virtual) + (b_virtual - b);
}

// Is (a - b) * (c - d) computed without rounding? It is for points on a grid, where most collinear points lie: doorways in a row.
static bool product_is_exact(double a, double b, double c, double d) {
    return difference_tail(a, b) == 0 && difference_tail(c, d) == 0 &&
           fma(a - b, c - d, -((a - b) * (c - d))) == 0;
}

int orient2d(Vec2 a, Vec2 b, Vec2 c) {
    double left = (a.x - c.x) * (b.y - c.y), right = (a.y - c.y) * (b.x - c.x);
    double det = left - right, bound = FILTER * (fabs(left) + fabs(right));
    if (det > bound) return 1;
    if (-det > bound) return -1;
    if (product_is_exact(a.x, c.x, b.y, c.y) && product_is_exact(a.y, c.y, b.x, c.x))
        return (det > 0) - (det < 0);
    return orient_exact(a, b, c);
}
