// polygon.c - Sutherland & Hodgman 1974 clipping by one plane, and ear clipping of convex polygons.
#include "engine/core/polygon.h"

// A remainder of a polygon with less than this share of the polygon's area counts as without area: rounding puts vertices a
// millionth of the polygon's length off a line.
static const double NO_AREA = 1e-6;

// The cut is computed from the lexicographically smaller end, so that it is the same from both sides.
static Vec3 cut_edge(Vec3 a, double da, Vec3 b, double db) {
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

// Clips where rounding has put several separate runs of corners below the plane: only the run with the deepest corner is cut off,
// and the others are no deeper than rounding. The result has at most one corner more, as for any convex polygon.
static int clip_deepest(const Vec3 *in, int count, Plane keep, double slack, Vec3 *out) {
    int deepest = 0, kept = 0;
    for (int i = 1; i < count; i++)
        if (plane_distance(keep, in[i]) < plane_distance(keep, in[deepest])) deepest = i;
    int first = deepest, last = deepest;  // the kept corners on either side of the run
    while (plane_distance(keep, in[first]) + slack < 0) first = (first + count - 1) % count;
    while (plane_distance(keep, in[last]) + slack < 0) last = (last + 1) % count;
    Vec3 in_first = in[(first + 1) % count], in_last = in[(last + count - 1) % count];
    out[kept++] = cut_edge(in_last, plane_distance(keep, in_last) + slack, in[last],
                           plane_distance(keep, in[last]) + slack);
    for (int i = last; i != first; i = (i + 1) % count) out[kept++] = in[i];
    out[kept++] = in[first];
    out[kept++] = cut_edge(in[first], plane_distance(keep, in[first]) + slack, in_first,
                           plane_distance(keep, in_first) + slack);
    return kept;
}

int polygon_clip(const Vec3 *in, int count, Plane keep, double slack, Vec3 *out) {
    int kept = 0;
    if (count == 0) return 0;
    Vec3 previous = in[count - 1];
    double before = plane_distance(keep, previous) + slack;
    for (int i = 0; i < count; i++) {
        Vec3 point = in[i];
        double here = plane_distance(keep, point) + slack;
        bool crosses = (before < 0) != (here < 0);
        if (kept + crosses + (here >= 0) > count + 1) return clip_deepest(in, count, keep, slack, out);
        if (crosses) out[kept++] = cut_edge(previous, before, point, here);
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

// Twice the area of a ring of vertices.
static double ring_area(const Vec3 *vertices, const int *ring, int count) {
    Vec3 sum = {0, 0, 0};
    for (int i = 1; i + 1 < count; i++)
        sum = vec3_add(sum, vec3_cross(vec3_sub(vertices[ring[i]], vertices[ring[0]]),
                                       vec3_sub(vertices[ring[i + 1]], vertices[ring[0]])));
    return vec3_length(sum);
}

// The fattest ear that leaves a remainder with area. An ear with the last corner that is not collinear leaves a line, whose
// vertices would be corners of no visible triangle; neighbours that share the line would show a seam.
static int find_ear(const Vec3 *vertices, const int *ring, int left) {
    double all = ring_area(vertices, ring, left), best_fatness = -INFINITY;
    int best = 0;
    for (int i = 0; i < left; i++) {
        int before = (i + left - 1) % left, after = (i + 1) % left;
        const int ear[3] = {ring[before], ring[i], ring[after]};
        double f = fatness(vertices[ear[0]], vertices[ear[1]], vertices[ear[2]]);
        if (left == 4)
            f = fmin(f, fatness(vertices[ear[2]], vertices[ring[(i + 2) % left]], vertices[ear[0]]));
        if (!(all - ring_area(vertices, ear, 3) > NO_AREA * all)) f -= 1;
        if (f <= best_fatness) continue;
        best_fatness = f;
        best = i;
    }
    return best;
}

void polygon_triangulate(const Vec3 *vertices, int count, int *triangle) {
    int ring[256];
    bool small = count <= 256;
    // A polygon too large for the buffer is cut into a fan: no reader makes polygons so large, and a fan is a triangulation too.
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
        int best = find_ear(vertices, ring, left);
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
    // Most polygons of furniture are triangles, which turn once where they turn left at all.
    if (count == 3 &&
        vec3_dot(vec3_cross(vec3_sub(vertices[1], vertices[0]), vec3_sub(vertices[2], vertices[1])), n) > 0)
        return true;
    for (int i = 0; i < count; i++) {
        Vec3 a = vertices[i], b = vertices[(i + 1) % count], c = vertices[(i + 2) % count];
        double sine = polygon_corner_sine(a, b, c, n), cosine_part = vec3_dot(vec3_sub(b, a), vec3_sub(c, b));
        if (sine < -POLYGON_COLLINEAR) return false;
        turn += atan2(sine * vec3_length(vec3_sub(b, a)) * vec3_length(vec3_sub(c, b)), cosine_part);
    }
    return fabs(turn - 2 * M_PI) < 1;
}
