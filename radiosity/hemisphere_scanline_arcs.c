// hemisphere_scanline_arcs.c - where the great circle of an edge crosses lines y = const of the hemisphere's base: the
// root of a quadratic, in closed form.
//
// With the unit normal e of the edge's plane and l2 = ex^2 + ez^2, the half-circle above the line meets the plane at
//     (x, z) = (-ex ey y +- ez s, -ez ey y -+ ex s) / l2,    s = sqrt(l2 - y^2),
// with the upper sign where y grows along the edge. An edge taken the other way round gives the same numbers to the last
// bit, so faces that share it leave neither a gap nor an overlap.
#include "radiosity/hemisphere_scanline.h"

static ScanArc arc(Vec3 e, double l2, bool grows, int k0, int k1) {
    double side = (grows ? 1 : -1) / l2;
    return (ScanArc){.a = -(e.x * e.y) / l2,
                     .b = e.z * side,
                     .c = -(e.z * e.y) / l2,
                     .e = -(e.x * side),
                     .l2 = l2,
                     .first = k0 < k1 ? k0 : k1,
                     .end = k0 < k1 ? k1 : k0};
}

int scan_arcs_of_edge(Vec3 a, double a_length, Vec3 b, double b_length, int lines, ScanArc *out) {
    int ka = scan_line_above(a.y / a_length, lines), kb = scan_line_above(b.y / b_length, lines);
    Vec3 e = vec3_normalize(vec3_cross(a, b));
    // How y changes on the way, at either end.
    double at_a = e.z * a.x - e.x * a.z, at_b = e.z * b.x - e.x * b.z;
    double l2 = e.x * e.x + e.z * e.z;
    bool turns = (at_a > 0) != (at_b > 0);
    if (!turns) {
        if (ka == kb) return 0;
        out[0] = arc(e, l2, at_a > 0, ka, kb);
        return 1;
    }
    // Over the top of the circle, or through its bottom.
    int top = scan_line_above(at_a > 0 ? sqrt(l2) : -sqrt(l2), lines), count = 0;
    if (ka != top) out[count++] = arc(e, l2, at_a > 0, ka, top);
    if (kb != top) out[count++] = arc(e, l2, at_b > 0, kb, top);
    return count;
}

int scan_roots(double alpha, double gamma, double t, const ScanLine *line, ScanPoint from, ScanPoint to,
               ScanPoint root[2]) {
    double h2 = alpha * alpha + gamma * gamma, s2 = h2 * line->radius2 - t * t;
    int count = 0;
    if (!(s2 > 0) || !(h2 > 0)) return 0;
    double s = sqrt(s2);
    for (int sign = -1; sign <= 1; sign += 2) {
        ScanPoint p = {(-alpha * t + sign * gamma * s) / h2, (-gamma * t - sign * alpha * s) / h2};
        if (p.x > from.x && p.x < to.x && p.z >= 0) root[count++] = p;
    }
    if (count == 2 && root[0].x > root[1].x) {
        ScanPoint p = root[0];
        root[0] = root[1];
        root[1] = p;
    }
    return count;
}
