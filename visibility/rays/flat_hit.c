// flat_hit.c - rays against polygons and boxes.
//
// Corners are moved along the ray into the plane across its longest component (Woop, Benthin & Wald 2013); there the ray is
// a point, inside where a half line from it crosses the outline an odd number of times. On which side of an edge it lies is
// decided exactly for corners as they were moved, which are the same for all polygons that have them.
#include "visibility/rays/flat_hit.h"

// The direction's longest component becomes z, by a turn of the axes.
static int longest_axis(Vec3 d) {
    double x = fabs(d.x), y = fabs(d.y), z = fabs(d.z);
    return x >= y && x >= z ? 0 : y >= z ? 1 : 2;
}

static Vec3 turned(Vec3 p, int axis) {
    if (axis == 0) return vec3(p.y, p.z, p.x);
    return axis == 1 ? vec3(p.z, p.x, p.y) : p;
}

static bool is_inside(const Vec3 *vertices, int count, const Ray *ray) {
    int axis = longest_axis(ray->direction);
    Vec3 d = turned(ray->direction, axis);
    Vec2 shear = {d.x / d.z, d.y / d.z}, ray_at = {0}, before = {0};
    bool inside = false;
    for (int i = -1; i < count; i++) {
        Vec3 p = turned(vec3_sub(vertices[i < 0 ? count - 1 : i], ray->origin), axis);
        Vec2 here = {p.x - shear.x * p.z, p.y - shear.y * p.z};
        if (i >= 0 && (before.y < 0) != (here.y < 0)) {
            int side = orient2d(before, here, ray_at);
            inside ^= here.y < 0 ? side < 0 : side > 0;
        }
        before = here;
    }
    return inside;
}

void polygon_hits(const Vec3 *vertices, int count, Plane plane, const Ray *ray, HitList *list) {
    double slope = vec3_dot(plane.n, ray->direction);
    if (slope == 0) return;
    double t = -plane_distance(plane, ray->origin) / slope;
    if (!hit_list_wants(list, t) || !is_inside(vertices, count, ray)) return;
    hit_list_add(list, (RayHit){.t = t, .normal = plane.n});
}

void box_hits(const Box *box, const Ray *ray, HitList *list) {
    const double o[3] = {ray->origin.x, ray->origin.y, ray->origin.z};
    const double d[3] = {ray->direction.x, ray->direction.y, ray->direction.z};
    const double min[3] = {box->min.x, box->min.y, box->min.z}, max[3] = {box->max.x, box->max.y, box->max.z};
    double t[2] = {-INFINITY, INFINITY};
    int face[2] = {0, 0};  // the axis
    for (int axis = 0; axis < 3; axis++) {
        if (d[axis] == 0) {
            if (!(min[axis] <= o[axis] && o[axis] <= max[axis])) return;
            continue;
        }
        double low = (min[axis] - o[axis]) / d[axis], high = (max[axis] - o[axis]) / d[axis];
        if (fmin(low, high) > t[0]) t[0] = fmin(low, high), face[0] = axis;
        if (fmax(low, high) < t[1]) t[1] = fmax(low, high), face[1] = axis;
    }
    if (!(t[0] <= t[1])) return;
    for (int end = 0; end < 2; end++) {
        double out = (d[face[end]] > 0) == (end == 1) ? 1 : -1;
        Vec3 n = {face[end] == 0 ? out : 0, face[end] == 1 ? out : 0, face[end] == 2 ? out : 0};
        hit_list_add(list, (RayHit){.t = t[end], .normal = n});
    }
}
