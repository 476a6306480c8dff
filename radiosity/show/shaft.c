// shaft.c - the planes about two convex things, and the tests of polygons against them.
#include "radiosity/show/shaft.h"

// Adds a plane if all points lie on one side of it.
static void add_bound(Shaft *shaft, Vec3 normal, Vec3 through, const Vec3 *one, int one_count,
                      const Vec3 *other, int other_count) {
    double length = vec3_length(normal), least = 0, most = 0;
    if (!(length > 0) || shaft->count == SHAFT_PLANES) return;
    Plane plane = {vec3_scale(normal, 1 / length), 0};
    plane.d = vec3_dot(plane.n, through);
    for (int i = 0; i < one_count + other_count; i++) {
        double distance = plane_distance(plane, i < one_count ? one[i] : other[i - one_count]);
        if (distance < least) least = distance;
        if (distance > most) most = distance;
        if (least < -SHAFT_TOUCH && most > SHAFT_TOUCH) return;
    }
    if (most <= SHAFT_TOUCH) plane = (Plane){vec3_scale(plane.n, -1), -plane.d};
    // The same plane is found from several edges.
    for (int i = 0; i < shaft->count; i++)
        if (vec3_dot(shaft->keep[i].n, plane.n) > 1 - 1e-12) return;
    shaft->keep[shaft->count++] = plane;
}

static Shaft about_box(Box all) {
    static const Vec3 AXIS[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    Shaft shaft = {0};
    for (int axis = 0; axis < 3; axis++) {
        shaft.keep[shaft.count++] = (Plane){AXIS[axis], vec3_component(all.min, axis)};
        shaft.keep[shaft.count++] = (Plane){vec3_scale(AXIS[axis], -1), -vec3_component(all.max, axis)};
    }
    shaft.closed = shaft.count;
    return shaft;
}

// The box about both, and planes through parallel edges of the two.
Shaft shaft_of_boxes(Box one, Box other) {
    static const Vec3 AXIS[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    Shaft shaft = about_box(box_union(one, other));
    Vec3 a[8], b[8];
    box_corners(one, a);
    box_corners(other, b);
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < 8; i++)
            if (!(i >> axis & 1))
                add_bound(&shaft, vec3_cross(AXIS[axis], vec3_sub(b[i], a[i])), a[i], a, 8, b, 8);
    return shaft;
}

// The box about both, the polygon's plane, and planes through an edge of the polygon and a corner of the box.
Shaft shaft_to_box(const Vec3 *polygon, int count, Plane from, Box box) {
    Box all = box;
    Vec3 corner[8];
    for (int i = 0; i < count; i++) all = box_add(all, polygon[i]);
    Shaft shaft = about_box(all);
    shaft.keep[shaft.count++] = from;
    box_corners(box, corner);
    for (int i = 0; i < count; i++) {
        Vec3 along = vec3_sub(polygon[i + 1 < count ? i + 1 : 0], polygon[i]);
        for (int k = 0; k < 8; k++)
            add_bound(&shaft, vec3_cross(along, vec3_sub(corner[k], polygon[i])), polygon[i], polygon, count,
                      corner, 8);
    }
    return shaft;
}

bool shaft_is_met(const Shaft *shaft, const Vec3 *corner, int count) {
    for (int p = 0; p < shaft->count; p++) {
        double least = p < shaft->closed ? -SHAFT_TOUCH : SHAFT_TOUCH;
        bool inside = false;
        for (int i = 0; i < count && !inside; i++) inside = plane_distance(shaft->keep[p], corner[i]) > least;
        if (!inside) return false;
    }
    return true;
}

// Does the segment from p to q, which lie on either side of the plane, meet the polygon?
static bool meets(const Vec3 *corner, int count, Plane plane, Vec3 p, Vec3 q) {
    double from = plane_distance(plane, p), to = plane_distance(plane, q);
    Vec3 at = vec3_lerp(p, q, from / (from - to));
    int left = 0, right = 0;
    for (int i = 0; i < count; i++) {
        Vec3 a = corner[i], b = corner[i + 1 < count ? i + 1 : 0];
        double side = vec3_dot(plane.n, vec3_cross(vec3_sub(b, a), vec3_sub(at, a)));
        left += side > 0;
        right += side < 0;
    }
    return left == 0 || right == 0;
}

bool shaft_is_closed(const Vec3 *corner, int count, Plane plane, const Vec3 *one, int one_count,
                     const Vec3 *other, int other_count) {
    double sign = plane_distance(plane, one[0]) < 0 ? -1 : 1;
    for (int i = 0; i < one_count; i++)
        if (sign * plane_distance(plane, one[i]) <= SHAFT_TOUCH) return false;
    for (int k = 0; k < other_count; k++)
        if (sign * plane_distance(plane, other[k]) >= -SHAFT_TOUCH) return false;
    for (int i = 0; i < one_count; i++)
        for (int k = 0; k < other_count; k++)
            if (!meets(corner, count, plane, one[i], other[k])) return false;
    return true;
}
