// polygon.c - Sutherland & Hodgman 1974 clipping by one plane, and ear clipping of convex polygons.
#include "engine/core/polygon.h"

// The cut is computed from the lexicographically smaller end, so that it is the same from both sides.
static Vec3 cut(Vec3 a, double da, Vec3 b, double db) {
    bool swap = a.x != b.x ? a.x > b.x : a.y != b.y ? a.y > b.y : a.z > b.z;
    if (swap) {
        Vec3 p = a;
        a = b;
        b = p;
        double d = da;
        da = db;
        db = d;
    }
    return vec3_lerp(a, b, da / (da - db));
}

int polygon_clip(const Vec3 *in, int count, Plane keep, double slack, Vec3 *out) {
    int kept = 0;
    if (count == 0) return 0;
    Vec3 previous = in[count - 1];
    double before = plane_distance(keep, previous) + slack;
    for (int i = 0; i < count; i++) {
        Vec3 point = in[i];
        double here = plane_distance(keep, point) + slack;
        if ((before < 0) != (here < 0)) out[kept++] = cut(previous, before, point, here);
        if (here >= 0) out[kept++] = point;
        previous = point;
        before = here;
    }
    return kept;
}

// Twice the area over the square of the longest side: 0 for a degenerate triangle, 0.87 for the best.
static double fatness(Vec3 a, Vec3 b, Vec3 c) {
    Vec3 ab = vec3_sub(b, a), ac = vec3_sub(c, a), bc = vec3_sub(c, b);
    double longest = fmax(vec3_dot(ab, ab), fmax(vec3_dot(ac, ac), vec3_dot(bc, bc)));
    return longest > 0 ? vec3_length(vec3_cross(ab, ac)) / longest : 0;
}

void polygon_triangulate(const Vec3 *vertices, int count, int *triangle) {
    int ring[256];
    bool small = count <= 256;
    // Beyond the buffer a fan does: no reader makes such polygons, and a fan is still a triangulation.
    if (!small) {
        for (int i = 0; i + 2 < count; i++) {
            triangle[3 * i] = 0;
            triangle[3 * i + 1] = i + 1;
            triangle[3 * i + 2] = i + 2;
        }
        return;
    }
    for (int i = 0; i < count; i++) ring[i] = i;
    for (int left = count; left > 2; left--) {
        int best = 0;
        double best_fatness = -1;
        for (int i = 0; i < left; i++) {
            int a = ring[(i + left - 1) % left], b = ring[i], c = ring[(i + 1) % left];
            double f = fatness(vertices[a], vertices[b], vertices[c]);
            // The other triangles at this corner must stay fat as well: an ear may not swallow the last
            // corner that is not collinear, which only matters for the last but one ear.
            if (left == 4) {
                int d = ring[(i + 2) % left];
                f = fmin(f, fatness(vertices[c], vertices[d], vertices[a]));
            }
            if (f > best_fatness) {
                best_fatness = f;
                best = i;
            }
        }
        *triangle++ = ring[(best + left - 1) % left];
        *triangle++ = ring[best];
        *triangle++ = ring[(best + 1) % left];
        for (int i = best; i + 1 < left; i++) ring[i] = ring[i + 1];
    }
}

double polygon_corner_sine(Vec3 a, Vec3 b, Vec3 c, Vec3 n) {
    Vec3 in = vec3_sub(b, a), out = vec3_sub(c, b);
    double lengths = vec3_length(in) * vec3_length(out);
    return lengths > 0 ? vec3_dot(vec3_cross(in, out), n) / lengths : 0;
}

double polygon_bend(const Vec3 *vertices, int count, Plane plane) {
    double worst = 0;
    for (int i = 0; i < count; i++) worst = fmax(worst, fabs(plane_distance(plane, vertices[i])));
    return worst;
}

bool polygon_is_convex(const Vec3 *vertices, int count, Vec3 n) {
    double turn = 0;
    for (int i = 0; i < count; i++) {
        Vec3 a = vertices[i], b = vertices[(i + 1) % count], c = vertices[(i + 2) % count];
        double sine = polygon_corner_sine(a, b, c, n), cosine_part = vec3_dot(vec3_sub(b, a), vec3_sub(c, b));
        if (sine < -POLYGON_COLLINEAR) return false;
        turn += atan2(sine * vec3_length(vec3_sub(b, a)) * vec3_length(vec3_sub(c, b)), cosine_part);
    }
    return fabs(turn - 2 * M_PI) < 1;
}
