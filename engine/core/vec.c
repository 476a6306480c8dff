// vec.c - the plane and the area of a polygon by Newell's sum over its edges.
#include "engine/core/vec.h"

static Vec3 newell(const Vec3 *v, int count) {
    Vec3 sum = {0, 0, 0};
    // Relative to the first vertex, or a building far from the origin loses its digits.
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
