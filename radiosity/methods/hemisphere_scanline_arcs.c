// hemisphere_scanline_arcs.c - where the great circle of an edge crosses lines y = const of the hemisphere's base: the
// root of a quadratic, in closed form.
//
// With the normal e of the edge's plane and h2 = ex^2 + ez^2, the half-circle above the line meets the plane at
//     (x, z) = (-ex ey y +- ez s, -ez ey y -+ ex s) / h2,    s = sqrt(h2 - |e|^2 y^2),
// with the upper sign where y grows along the edge. An edge taken the other way round gives the same numbers to the last
// bit, so faces that share it leave neither a gap nor an overlap.
#include "radiosity/methods/hemisphere_scanline.h"

static ScanArc arc(Vec3 e, double h2, double e2, bool grows, int k0, int k1) {
    double scale = 1 / h2, side = grows ? scale : -scale;
    return (ScanArc){.a = -(e.x * e.y) * scale,
                     .b = e.z * side,
                     .c = -(e.z * e.y) * scale,
                     .e = -(e.x * side),
                     .h2 = h2,
                     .e2 = e2,
                     .first = k0 < k1 ? k0 : k1,
                     .end = k0 < k1 ? k1 : k0};
}

int scan_arcs_of_edge(const ScanCorner *from, const ScanCorner *to, const ScanLattice *lattice,
                      ScanArc *out) {
    Vec3 a = from->at, b = to->at, e = vec3_cross(a, b);
    int ka = from->line, kb = to->line;
    // How y changes on the way, at either end.
    double at_a = e.z * a.x - e.x * a.z, at_b = e.z * b.x - e.x * b.z;
    bool turns = (at_a > 0) != (at_b > 0);
    if (!turns && ka == kb) return 0;
    double h2 = e.x * e.x + e.z * e.z, e2 = h2 + e.y * e.y;
    if (!turns) {
        out[0] = arc(e, h2, e2, at_a > 0, ka, kb);
        return 1;
    }
    // Over the top of the circle, or through its bottom.
    double highest = sqrt(h2 / e2);
    int top = scan_line_above(at_a > 0 ? highest : -highest, lattice), count = 0;
    if (ka != top) out[count++] = arc(e, h2, e2, at_a > 0, ka, top);
    if (kb != top) out[count++] = arc(e, h2, e2, at_b > 0, kb, top);
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
