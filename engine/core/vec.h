// vec.h - points, vectors, planes and boxes in double precision.
//
// Building space: metres, right-handed, z up. Plan space: the same x and y, seen from above.
#ifndef CORE_VEC_H
#define CORE_VEC_H

#include <math.h>
#include <stdbool.h>

// A point or vector in plan.
typedef struct Vec2 {
    double x, y;
} Vec2;

// A point or vector in space.
typedef struct Vec3 {
    double x, y, z;
} Vec3;

// The points p with dot(n, p) = d; n has unit length and points to the open side.
typedef struct Plane {
    Vec3 n;
    double d;
} Plane;

// All points between two corners; empty where min > max.
typedef struct Box {
    Vec3 min, max;
} Box;

// Vectors in plan: from components, sum, difference, multiple, inner product, z of the cross product (positive where b lies to the
// left of a), length, exact equality.
static inline Vec2 vec2(double x, double y) { return (Vec2){x, y}; }
static inline Vec2 vec2_add(Vec2 a, Vec2 b) { return vec2(a.x + b.x, a.y + b.y); }
static inline Vec2 vec2_sub(Vec2 a, Vec2 b) { return vec2(a.x - b.x, a.y - b.y); }
static inline Vec2 vec2_scale(Vec2 a, double s) { return vec2(a.x * s, a.y * s); }
static inline double vec2_dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }
static inline double vec2_cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }
static inline double vec2_length(Vec2 a) { return sqrt(vec2_dot(a, a)); }
static inline bool vec2_equal(Vec2 a, Vec2 b) { return a.x == b.x && a.y == b.y; }

// The same for vectors in space, and component 0, 1 or 2, the cross product, and the point at share t of the way from a to b.
static inline Vec3 vec3(double x, double y, double z) { return (Vec3){x, y, z}; }
static inline double vec3_component(Vec3 v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }
static inline Vec3 vec3_add(Vec3 a, Vec3 b) { return vec3(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline Vec3 vec3_sub(Vec3 a, Vec3 b) { return vec3(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline Vec3 vec3_scale(Vec3 a, double s) { return vec3(a.x * s, a.y * s, a.z * s); }
static inline double vec3_dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline Vec3 vec3_cross(Vec3 a, Vec3 b) {
    return vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline double vec3_length(Vec3 a) { return sqrt(vec3_dot(a, a)); }
static inline Vec3 vec3_lerp(Vec3 a, Vec3 b, double t) { return vec3_add(a, vec3_scale(vec3_sub(b, a), t)); }
static inline bool vec3_equal(Vec3 a, Vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

// The zero vector stays zero.
static inline Vec3 vec3_normalize(Vec3 a) {
    double length = vec3_length(a);
    return length > 0 ? vec3_scale(a, 1 / length) : a;
}

// Signed distance: positive on the open side.
static inline double plane_distance(Plane plane, Vec3 p) { return vec3_dot(plane.n, p) - plane.d; }

// The plane of a polygon by Newell's sum, which is right for convex, concave and slightly bent polygons; n is zero when the polygon
// has no area.
Plane plane_of_polygon(const Vec3 *vertices, int count);
// The area of a polygon; for a bent polygon, the area of its projection along Newell's normal.
double polygon_area(const Vec3 *vertices, int count);

// +1 when c lies left of the directed line a -> b, -1 right of it, 0 exactly on it. The sign is exact for all
// finite coordinates whose products neither overflow nor underflow.
int orient2d(Vec2 a, Vec2 b, Vec2 c);

// The empty box, to which points can be added.
static inline Box box_empty(void) {
    return (Box){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
}
static inline bool box_is_empty(Box b) { return !(b.min.x <= b.max.x); }
// The box that also contains p. Comparisons give the result of fmin and fmax, which the compiler may not inline. Coordinates that
// are NaN add nothing.
static inline Box box_add(Box b, Vec3 p) {
    return (Box){
        {p.x <= b.min.x ? p.x : b.min.x, p.y <= b.min.y ? p.y : b.min.y, p.z <= b.min.z ? p.z : b.min.z},
        {p.x >= b.max.x ? p.x : b.max.x, p.y >= b.max.y ? p.y : b.max.y, p.z >= b.max.z ? p.z : b.max.z}};
}
static inline Box box_union(Box a, Box b) { return box_add(box_add(a, b.min), b.max); }
static inline Box box_grow(Box b, double by) {
    return (Box){{b.min.x - by, b.min.y - by, b.min.z - by}, {b.max.x + by, b.max.y + by, b.max.z + by}};
}
// Corner i has the greater x, y, z where bit 0, 1, 2 of i is set.
static inline void box_corners(Box b, Vec3 out[8]) {
    for (int i = 0; i < 8; i++)
        out[i] = vec3(i & 1 ? b.max.x : b.min.x, i & 2 ? b.max.y : b.min.y, i & 4 ? b.max.z : b.min.z);
}
static inline bool box_overlap(Box a, Box b) {
    return a.min.x <= b.max.x && b.min.x <= a.max.x && a.min.y <= b.max.y && b.min.y <= a.max.y &&
           a.min.z <= b.max.z && b.min.z <= a.max.z;
}
static inline bool box_contains(Box b, Vec3 p) {
    return p.x >= b.min.x && p.x <= b.max.x && p.y >= b.min.y && p.y <= b.max.y && p.z >= b.min.z &&
           p.z <= b.max.z;
}

#endif
