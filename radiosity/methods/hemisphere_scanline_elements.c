// hemisphere_scanline_elements.c - the elements along a span of a scan line, by where it crosses the lines of its face's
// grid.
//
// A line of the grid and the eye span a plane like an edge does, so the crossings are roots of the same quadratic. On the
// face the scan line is a conic: where it turns in x or y of the grid, the span is cut, and between cuts the grid is
// walked in one direction.
#include "radiosity/methods/hemisphere_scanline.h"

ScanAxis scan_axis(Vec3 g, double offset, int count, Vec3 inverse) {
    Vec3 across = vec3_cross(g, inverse);
    double y2 = across.y * across.y;
    return (ScanAxis){g, offset, count, across, y2 / (across.x * across.x + y2 + across.z * across.z)};
}

typedef struct GridWalk {
    int at, end, step;
    double next;  // x of the next crossing, INFINITY: no more
} GridWalk;

static double place_along(Vec3 v, double y, ScanPoint p) { return v.x * p.x + v.y * y + v.z * p.z; }

// Where the walk leaves its square. Along it the coordinate grows with `step`, which tells the two roots apart.
static double crossing_out(const ScanAxis *axis, Vec3 inverse, const ScanLine *line, const GridWalk *walk) {
    double i = walk->at + (walk->step > 0) - axis->offset;
    Vec3 e = vec3_sub(axis->g, vec3_scale(inverse, i));
    double t = e.y * line->y, h2 = e.x * e.x + e.z * e.z, s2 = h2 * line->radius2 - t * t;
    return (-e.x * t - walk->step * e.z * sqrt(s2 > 0 ? s2 : 0)) / h2;
}

// From a point to another; the distances of the face there.
static GridWalk walk_from(const ScanAxis *axis, Vec3 inverse, const ScanLine *line, ScanPoint from,
                          double from_distance, ScanPoint to, double to_distance) {
    GridWalk walk = {.next = INFINITY};
    if (axis->count == 1) return walk;
    walk.at =
        face_grid_clamp(place_along(axis->g, line->y, from) * from_distance + axis->offset, axis->count);
    walk.end = face_grid_clamp(place_along(axis->g, line->y, to) * to_distance + axis->offset, axis->count);
    walk.step = walk.end > walk.at ? 1 : -1;
    if (walk.at != walk.end) walk.next = crossing_out(axis, inverse, line, &walk);
    return walk;
}

static void walk_on(GridWalk *walk, const ScanAxis *axis, Vec3 inverse, const ScanLine *line) {
    walk->at += walk->step;
    walk->next = walk->at != walk->end ? crossing_out(axis, inverse, line, walk) : INFINITY;
}

static void add_share(const FaceGrid *grid, int i, int j, double share, RowSum *sum) {
    if (!(share > 0)) return;
    row_add(sum, face_grid_element(grid, i, j), share);
}

// A part of a span along which neither coordinate turns.
static int walk_grid(const ScanFace *face, const ScanLine *line, ScanPoint from, ScanPoint to, RowSum *sum) {
    const ScanAxis *axis = face->axis;
    double d0 = 1 / place_along(face->inverse, line->y, from),
           d1 = 1 / place_along(face->inverse, line->y, to);
    GridWalk x = walk_from(&axis[0], face->inverse, line, from, d0, to, d1);
    GridWalk y = walk_from(&axis[1], face->inverse, line, from, d0, to, d1);
    double at = from.x;
    int pieces = 1;
    for (; x.at != x.end || y.at != y.end; pieces++) {
        bool by_x = x.next <= y.next;
        double next = by_x ? x.next : y.next;
        // Rounding may put a crossing outside.
        next = next < at ? at : next < to.x ? next : to.x;
        add_share(&face->grid, x.at, y.at, (next - at) * line->weight, sum);
        at = next;
        if (by_x)
            walk_on(&x, &axis[0], face->inverse, line);
        else
            walk_on(&y, &axis[1], face->inverse, line);
    }
    add_share(&face->grid, x.at, y.at, (to.x - at) * line->weight, sum);
    return pieces;
}

// Where the coordinate turns: the scan line's tangent, its point and the grid's lines are in one plane.
static int turns(const ScanAxis *axis, const ScanLine *line, const ScanSpan *span, ScanPoint turn[2]) {
    if (axis->count == 1 || axis->vanishes >= line->y * line->y) return 0;
    Vec3 q = axis->across;
    double qx = q.x * line->y, qz = q.z * line->y, t = -q.y * line->radius2;
    double a = qx * span->from.x + qz * span->from.z + t, b = qx * span->to.x + qz * span->to.z + t;
    // One sign at both ends, and curved away from 0 between them.
    if (a * b > 0 && a * qz >= 0) return 0;
    return scan_roots(qx, qz, t, line, span->from, span->to, turn);
}

int scan_elements(const ScanFace *face, const ScanLine *line, const ScanSpan *span, RowSum *sum) {
    const FaceGrid *g = &face->grid;
    if (g->nx * g->ny == 1) {
        add_share(g, 0, 0, (span->to.x - span->from.x) * line->weight, sum);
        return 1;
    }
    ScanPoint cut[6] = {span->from};
    int count = 1 + turns(&face->axis[0], line, span, cut + 1);
    count += turns(&face->axis[1], line, span, cut + count);
    for (int i = 1; i < count; i++)
        for (int j = i; j > 1 && cut[j].x < cut[j - 1].x; j--) {
            ScanPoint p = cut[j];
            cut[j] = cut[j - 1];
            cut[j - 1] = p;
        }
    cut[count] = span->to;
    int pieces = 0;
    for (int i = 0; i < count; i++) pieces += walk_grid(face, line, cut[i], cut[i + 1], sum);
    return pieces;
}
