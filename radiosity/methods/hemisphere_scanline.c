// hemisphere_scanline.c - form factors by lines over the hemisphere's base: visible lengths along scan lines
// (Doi & Itoh, eq. 8; Nusselt's analogue).
//
// Departure from the paper: nothing is cut into chords. A quadratic gives the point where an edge crosses a line, faces hide each
// other by their exact distances, and elements begin where the line crosses the face's grid. The only error left comes from the
// strips between lines.
//
// Lines run at 45 degrees to the view's axes, because buildings are mostly aligned with these axes, and a line that runs along an
// edge sees all of the face there or nothing. The turn halves the error in an office.
//
// Lines are processed in bands, so that the crossings of a face with several lines are found together and memory does not grow with
// the number of lines.
#include "engine/core/error.h"
#include "engine/core/polygon.h"
#include "radiosity/factors/face_grid.h"
#include "radiosity/factors/row.h"

typedef struct ScanLine {
    double y, radius2, radius;  // radius: of the half-circle above the line
    double weight;              // share of the light for a unit of length
} ScanLine;

// Lines over the disc: line k is at y = -1 + 2 (k + offset) / count, or, even in angle, at y = -cos(pi (k + offset) / count).
typedef struct ScanLattice {
    int count;
    double offset;
    bool by_angle;
    ScanLine *line;  // [count]
} ScanLattice;

typedef struct Scanner Scanner;

// A corner of a face above the horizon.
typedef struct ScanCorner {
    Vec3 at;
    double inverse;  // 1 / distance
    int line;        // the first line at or above the corner
} ScanCorner;

// A piece of an edge's great circle along which y only grows or only falls. It crosses lines first .. end - 1 at x = ay + bs,
// z = cy + es, where s = sqrt(h2 - e2 y^2).
typedef struct ScanArc {
    double a, b, c, e, h2, e2;
    int first, end;
} ScanArc;

typedef struct ScanPoint {
    double x, z;
} ScanPoint;

// A stretch of a line on which a face lies.
typedef struct ScanSpan {
    ScanPoint from, to;
    int face;  // index in Scanner.faces; -1: a gap
} ScanSpan;

// One coordinate of a face's grid along direction w: dot(g, w) / dot(inverse, w) + offset.
typedef struct ScanAxis {
    Vec3 g;
    double offset;
    int count;
    Vec3 across;      // g x inverse: the direction of the grid's lines
    double vanishes;  // y^2 of the vanishing point of the grid's lines
} ScanAxis;

typedef struct ScanFace {
    Vec3 inverse;  // 1 / distance along direction w is dot(inverse, w)
    int face;      // ViewFace.face
    int rank;      // form_factor_rank
    int first_arc, arc_count, first_line, end_line;
    bool back, has_grid;
    FaceGrid grid;     // valid where has_grid
    ScanAxis axis[2];  // valid where has_grid
} ScanFace;

// The index of the first line at or above y; `count` where there is none.
static inline int scan_line_above(double y, const ScanLattice *lattice) {
    double at = (y + 1) * 0.5;
    if (lattice->by_angle) at = acos(y > -1 ? y < 1 ? -y : -1 : 1) / M_PI;
    double k = ceil(at * lattice->count - lattice->offset);
    return k < 0 ? 0 : k > lattice->count ? lattice->count : (int)k;
}

// The visible spans of a line, as a list in x.
typedef struct ScanList {
    ScanSpan *span;  // [capacity]
    int *next;       // [capacity] -1: last
    int first, count, capacity;
    int free;  // the first span of the list of unused spans, -1: none
    long long tests;
} ScanList;

// ---- where the great circle of an edge crosses lines y = const of the hemisphere's base: the
// root of a quadratic, in closed form.
//
// With the normal e of the edge's plane and h2 = ex^2 + ez^2, the half-circle above the line meets the plane at
//     (x, z) = (-ex ey y +- ez s, -ez ey y -+ ex s) / h2,    s = sqrt(h2 - |e|^2 y^2),
// with the upper sign where y grows along the edge. The reversed edge gives the same numbers to the last bit, so faces that share
// an edge leave neither a gap nor an overlap.

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

// Stores the arcs of the edge between two corners in `out`. Returns how many there are, up to 2.
static int scan_arcs_of_edge(const ScanCorner *from, const ScanCorner *to, const ScanLattice *lattice,
                             ScanArc *out) {
    Vec3 a = from->at, b = to->at, e = vec3_cross(a, b);
    int ka = from->line, kb = to->line;
    // The direction in which y changes along the edge, at either end.
    double at_a = e.z * a.x - e.x * a.z, at_b = e.z * b.x - e.x * b.z;
    bool turns = (at_a > 0) != (at_b > 0);
    if (!turns && ka == kb) return 0;
    double h2 = e.x * e.x + e.z * e.z, e2 = h2 + e.y * e.y;
    if (!turns) {
        out[0] = arc(e, h2, e2, at_a > 0, ka, kb);
        return 1;
    }
    // The edge passes the top or the bottom of its great circle.
    double highest = sqrt(h2 / e2);
    int top = scan_line_above(at_a > 0 ? highest : -highest, lattice), count = 0;
    if (ka != top) out[count++] = arc(e, h2, e2, at_a > 0, ka, top);
    if (kb != top) out[count++] = arc(e, h2, e2, at_b > 0, kb, top);
    return count;
}

// Finds the points where alpha x + gamma z + t = 0 strictly between two points of a line: up to 2, increasing in x.
static int scan_roots(double alpha, double gamma, double t, const ScanLine *line, ScanPoint from,
                      ScanPoint to, ScanPoint root[2]) {
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

// ---- the visible faces along a scan line: spans in the order of x, each with its nearest face.
//
// Two faces are compared by the inverse distances of their planes. Their difference along a line, with z = sqrt(R^2 - x^2), is
// alpha x + gamma z + t: exact, with at most two changes of sign. Where the scan line coincides with the line in which two faces
// meet, the difference is 0 everywhere. As a scan line stands for the faces just above it (scan_line_above), the faces are then
// compared there.

// Two inverse distances are equal if they differ by less than this, as a share: above the noise of doubles, below the difference of
// sheets 2e-7 m apart in a room of many metres.
#define SCAN_SAME 1e-12

static int new_span(ScanList *list, ScanSpan span, int next) {
    int at = list->free;
    if (at >= 0)
        list->free = list->next[at];
    else
        at = list->count++;
    CORE_ASSERT(at < list->capacity);
    list->span[at] = span;
    list->next[at] = next;
    return at;
}

// Joins neighbouring spans of the same face. There are then about as many spans as ends of added spans, and each addition cuts a
// span into a few.
static void join_spans(ScanList *list) {
    for (int s = list->first; s >= 0; s = list->next[s])
        for (int n; (n = list->next[s]) >= 0 && list->span[n].face == list->span[s].face &&
                    list->span[n].from.x == list->span[s].to.x;) {
            list->span[s].to = list->span[n].to;
            list->next[s] = list->next[n];
            list->next[n] = list->free;
            list->free = n;
        }
}

static ScanPoint between(const ScanLine *line, ScanPoint a, ScanPoint b) {
    double x = (a.x + b.x) / 2, z2 = line->radius2 - x * x;
    return (ScanPoint){x, z2 > 0 ? sqrt(z2) : 0};
}

// The order of two faces along a line: the first face is nearer where alpha x + gamma z + t > 0.
typedef struct Order {
    double alpha, beta, gamma, t, noise;  // t is beta times the line's y
    bool first_of_same;                   // at equal distance, the first face is seen
} Order;

static double order_at(const Order *o, ScanPoint p) {
    double d = o->alpha * p.x + o->gamma * p.z + o->t;
    return fabs(d) <= o->noise ? 0 : d;
}

static Order order_of(const ScanFace *a, const ScanFace *b, const ScanLine *line, ScanPoint at) {
    Vec3 p = a->inverse, q = b->inverse;
    double inverse = fabs(p.x * at.x + p.y * line->y + p.z * at.z);
    double beta = p.y - q.y;
    return (Order){p.x - q.x, beta, p.z - q.z, beta * line->y, SCAN_SAME * inverse, a->rank < b->rank};
}

// 1: the first face is nearer all along; -1: the second; 0: the order changes, or needs a closer test.
static int nearer_all_along(const Order *o, ScanPoint from, ScanPoint to) {
    double d0 = order_at(o, from), d1 = order_at(o, to);
    if (d0 * d1 < 0 || (d0 == 0 && d1 == 0)) return 0;
    int sign = d0 + d1 > 0 ? 1 : -1;
    // Between ends of one sign the difference may change sign twice, if it moves towards 0 at both ends.
    double slope0 = sign * (o->alpha * from.z - o->gamma * from.x);
    double slope1 = sign * (o->alpha * to.z - o->gamma * to.x);
    return slope0 < 0 && slope1 > 0 ? 0 : sign;
}

static bool nearer_between(const Order *o, const ScanLine *line, ScanPoint from, ScanPoint to) {
    ScanPoint middle = between(line, from, to);
    double d = order_at(o, middle);
    if (d != 0) return d > 0;
    // The derivative of the difference by y, times z, with dz / dy = -y / z.
    double above = o->beta * middle.z - o->gamma * line->y;
    return fabs(above) <= o->noise ? o->first_of_same : above > 0;
}

// Puts `face` on the part from .. to of span s; `link` is the index that leads to s.
static void overwrite(ScanList *list, int s, int *link, ScanPoint from, ScanPoint to, int face) {
    ScanSpan *old = &list->span[s];
    if (to.x < old->to.x) {
        int tail = new_span(list, (ScanSpan){to, old->to, old->face}, list->next[s]);
        list->next[s] = tail;
        old->to = to;
    }
    if (from.x > old->from.x) {
        int head = new_span(list, (ScanSpan){old->from, from, old->face}, s);
        *link = head;
        old->from = from;
    }
    old->face = face;
}

// Decides which face is seen on the part from .. to that a new face shares with span s.
static void share(ScanList *list, const ScanFace *faces, const ScanLine *line, int s, int *link,
                  ScanPoint from, ScanPoint to, int face) {
    Order o = order_of(&faces[face], &faces[list->span[s].face], line, from);
    list->tests++;
    int sign = nearer_all_along(&o, from, to);
    if (sign > 0) overwrite(list, s, link, from, to, face);
    if (sign != 0) return;
    ScanPoint cut[4] = {from};
    int count = 1 + scan_roots(o.alpha, o.gamma, o.t, line, from, to, cut + 1);
    cut[count] = to;
    bool wins[3];
    for (int i = 0; i < count; i++) wins[i] = nearer_between(&o, line, cut[i], cut[i + 1]);
    // From right to left, so that the part not yet decided stays in span s.
    for (int i = count - 1; i >= 0; i--) {
        if (!wins[i]) continue;
        if (i == 0) {
            overwrite(list, s, link, from, cut[1], face);
            continue;
        }
        int tail = new_span(list, (ScanSpan){cut[i], list->span[s].to, list->span[s].face}, list->next[s]);
        list->span[s].to = cut[i];
        list->next[s] = tail;
        overwrite(list, tail, &list->next[s], cut[i], cut[i + 1], face);
    }
}

// Adds a span to the list, on the parts where it is nearer than the spans there.
static void scan_list_add(ScanList *list, const ScanFace *faces, const ScanLine *line,
                          const ScanSpan *added) {
    ScanPoint from = added->from, to = added->to;
    int *link = &list->first;
    if (list->count > list->capacity / 4) join_spans(list);
    while (*link >= 0 && list->span[*link].to.x <= from.x) link = &list->next[*link];
    while (from.x < to.x) {
        int s = *link;
        if (s < 0 || list->span[s].from.x >= to.x) {
            *link = new_span(list, (ScanSpan){from, to, added->face}, s);
            return;
        }
        if (from.x < list->span[s].from.x) {
            ScanPoint gap_end = list->span[s].from;
            *link = new_span(list, (ScanSpan){from, gap_end, added->face}, s);
            link = &list->next[*link];
            from = gap_end;
        }
        ScanPoint end = list->span[s].to.x < to.x ? list->span[s].to : to;
        share(list, faces, line, s, link, from, end, added->face);
        while (*link >= 0 && list->span[*link].to.x <= end.x) link = &list->next[*link];
        from = end;
    }
}

// ---- the elements along a span of a scan line, from its crossings with the lines of the face's grid.
//
// A line of the grid and the eye span a plane like an edge does, so the crossings are roots of the same quadratic. On the
// face the scan line is a conic: the span is cut where the conic turns in x or y of the grid, and between cuts the grid is
// walked in one direction.

static ScanAxis scan_axis(Vec3 g, double offset, int count, Vec3 inverse) {
    Vec3 across = vec3_cross(g, inverse);
    double y2 = across.y * across.y;
    return (ScanAxis){g, offset, count, across, y2 / (across.x * across.x + y2 + across.z * across.z)};
}

typedef struct GridWalk {
    int at, end, step;
    double next;  // x of the next crossing, INFINITY: no more
} GridWalk;

static double place_along(Vec3 v, double y, ScanPoint p) { return v.x * p.x + v.y * y + v.z * p.z; }

// The x at which the walk leaves its square. The coordinate grows in the direction of `step`, which selects one of the two roots.
static double crossing_out(const ScanAxis *axis, Vec3 inverse, const ScanLine *line, const GridWalk *walk) {
    double i = walk->at + (walk->step > 0) - axis->offset;
    Vec3 e = vec3_sub(axis->g, vec3_scale(inverse, i));
    double t = e.y * line->y, h2 = e.x * e.x + e.z * e.z, s2 = h2 * line->radius2 - t * t;
    return (-e.x * t - walk->step * e.z * sqrt(s2 > 0 ? s2 : 0)) / h2;
}

// Starts a walk from one point to another, at which the face has the distances given.
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

// Adds the elements on a part of a span along which neither grid coordinate turns. Returns how many pieces there are.
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
        // Rounding may put a crossing outside the part.
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

// Finds the points where the grid coordinate turns: the tangent of the scan line, its point and the direction of the grid's lines
// lie in one plane.
static int turns(const ScanAxis *axis, const ScanLine *line, const ScanSpan *span, ScanPoint turn[2]) {
    if (axis->count == 1 || axis->vanishes >= line->y * line->y) return 0;
    Vec3 q = axis->across;
    double qx = q.x * line->y, qz = q.z * line->y, t = -q.y * line->radius2;
    double a = qx * span->from.x + qz * span->from.z + t, b = qx * span->to.x + qz * span->to.z + t;
    // The sign is the same at both ends, and the function is curved away from 0 between them.
    if (a * b > 0 && a * qz >= 0) return 0;
    return scan_roots(qx, qz, t, line, span->from, span->to, turn);
}

// Adds the elements along a span of a face to the sum. Returns how many pieces there are.
static int scan_elements(const ScanFace *face, const ScanLine *line, const ScanSpan *span, RowSum *sum) {
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

// Visible spans shorter than this are rounding where edges meet, and are added to the span before them.
#define SCAN_SLIVER 1e-12
enum { SCAN_BAND = 16 };

struct Scanner {
    const Mesh *mesh;
    const View *view;
    bool across;          // corners are in the axes of the lines the other way
    ScanLattice lattice;  // the lattice being scanned
    int corners;          // the most vertices of a face
    ScanFace *faces;      // [mesh face_count] of the view
    ScanCorner *corner;   // [outline_count + mesh face_count] of the view, for both ways
    int *first_corner;    // [mesh face_count + 1] the first corner of each of view->faces
    ScanArc *arcs;        // [arc_capacity] of the view
    int face_count, arc_capacity;
    Vec3 *clipped;        // [corners + 1]
    ScanPoint *crossing;  // [SCAN_BAND][2 * corners + 2]
    int *crossings;       // [most lines + 1] the crossings of a line with all faces
    ScanSpan *span;  // [span_capacity] of the lines of a band, line after line, faces in the view's order
    int span_first[SCAN_BAND], span_count[SCAN_BAND], span_capacity;
    ScanList list;
};

// A scanner for lattices of at most `most_lines` lines.
static Scanner *scanner_new(const Mesh *mesh, int most_lines, Arena *arena) {
    Scanner *self = ARENA_ARRAY(arena, Scanner, 1);
    self->mesh = mesh;
    for (int i = 0; i < mesh->face_count; i++)
        if (mesh->faces[i].vertex_count > self->corners) self->corners = mesh->faces[i].vertex_count;
    self->faces = ARENA_ARRAY(arena, ScanFace, mesh->face_count);
    self->corner = ARENA_ARRAY(arena, ScanCorner, mesh->outline_count + mesh->face_count);
    self->first_corner = ARENA_ARRAY(arena, int, mesh->face_count + 1);
    self->arc_capacity = 2 * (mesh->outline_count + mesh->face_count);
    self->arcs = ARENA_ARRAY(arena, ScanArc, self->arc_capacity);
    self->clipped = ARENA_ARRAY(arena, Vec3, self->corners + 1);
    self->crossing = ARENA_ARRAY(arena, ScanPoint, SCAN_BAND * (2 * self->corners + 2));
    self->crossings = ARENA_ARRAY(arena, int, most_lines + 1);
    // A line crosses an edge twice at most.
    self->span_capacity = self->arc_capacity / 2;
    self->span = ARENA_ARRAY(arena, ScanSpan, self->span_capacity);
    self->list.capacity = 4 * self->span_capacity + 64;
    self->list.span = ARENA_ARRAY(arena, ScanSpan, self->list.capacity);
    self->list.next = ARENA_ARRAY(arena, int, self->list.capacity);
    return self;
}

// Turns a vector from the view's axes to the lines' axes.
static Vec3 to_lines(Vec3 v) { return vec3((v.x - v.y) * M_SQRT1_2, (v.x + v.y) * M_SQRT1_2, v.z); }

// The corners of a face's part above the horizon.
static int find_corners(Scanner *self, const ViewFace *face, ScanCorner *out) {
    const Vec3 *v = self->view->vertices + face->first_vertex;
    int count = face->vertex_count;
    bool below = false;
    for (int i = 0; i < count; i++) below |= v[i].z < 0;
    if (below) {
        count = polygon_clip(v, count, (Plane){vec3(0, 0, 1), 0}, 0, self->clipped);
        v = self->clipped;
    }
    for (int i = 0; i < count; i++) out[i] = (ScanCorner){to_lines(v[i]), 1 / vec3_length(v[i]), 0};
    return count;
}

// Sets the view that scanner_see scans.
static void scanner_look(Scanner *self, const View *view) {
    int corners = 0;
    self->view = view;
    self->across = false;
    for (int i = 0; i < view->face_count; i++) {
        self->first_corner[i] = corners;
        corners += find_corners(self, &view->faces[i], self->corner + corners);
    }
    self->first_corner[view->face_count] = corners;
}

static int find_arcs(const Scanner *self, int face, ScanArc *out) {
    int first = self->first_corner[face], end = self->first_corner[face + 1], arcs = 0;
    for (int i = first, last = end - 1; i < end; last = i++)
        arcs += scan_arcs_of_edge(&self->corner[last], &self->corner[i], &self->lattice, out + arcs);
    return arcs;
}

// Turns all corners to the axes of the lines the other way, or back.
static void turn_corners(Scanner *self, int count) {
    for (int i = 0; i < count; i++) {
        Vec3 p = self->corner[i].at;
        self->corner[i].at = vec3(p.y, p.x, p.z);
    }
}

static void find_lines(Scanner *self, int count) {
    for (ScanCorner *c = self->corner; c < self->corner + count; c++)
        c->line = scan_line_above(c->at.y * c->inverse, &self->lattice);
}

// Like to_lines; with `turn`, to the axes of the lines the other way.
static Vec3 turned(Vec3 v, bool turn) {
    Vec3 w = to_lines(v);
    return turn ? vec3(w.y, w.x, w.z) : w;
}

static void find_faces(Scanner *self) {
    const View *view = self->view;
    int arcs = 0;
    find_lines(self, self->first_corner[view->face_count]);
    self->face_count = 0;
    for (int i = 0; i < view->face_count; i++) {
        const ViewFace *face = &view->faces[i];
        ScanFace *f = &self->faces[self->face_count];
        int count = find_arcs(self, i, self->arcs + arcs);
        if (count == 0) continue;
        f->face = face->face;
        f->rank = form_factor_rank(face);
        f->first_arc = arcs, f->arc_count = count;
        f->first_line = self->lattice.count, f->end_line = 0;
        f->has_grid = false;
        arcs += count;
        f->inverse = vec3_scale(turned(face->n, self->across), 1 / face->d);
        f->back = face->d > 0;
        for (int k = f->first_arc; k < arcs; k++) {
            if (self->arcs[k].first < f->first_line) f->first_line = self->arcs[k].first;
            if (self->arcs[k].end > f->end_line) f->end_line = self->arcs[k].end;
        }
        self->face_count++;
    }
    CORE_ASSERT(arcs <= self->arc_capacity);
    int *crossings = self->crossings;
    for (int k = 0; k <= self->lattice.count; k++) crossings[k] = 0;
    for (int i = 0; i < arcs; i++) crossings[self->arcs[i].first]++, crossings[self->arcs[i].end]--;
    for (int k = 1; k <= self->lattice.count; k++) crossings[k] += crossings[k - 1];
}

// Starts a band at line k0, with as many lines as there is room for spans; returns the end of the band.
static int next_band(Scanner *self, int k0) {
    int spans = 0, k = k0;
    for (; k < self->lattice.count && k < k0 + SCAN_BAND; k++) {
        if (spans + self->crossings[k] / 2 > self->span_capacity) break;
        self->span_first[k - k0] = spans;
        self->span_count[k - k0] = 0;
        spans += self->crossings[k] / 2;
    }
    CORE_ASSERT(k > k0);
    return k;
}

static void sort_points(ScanPoint *p, int count) {
    for (int i = 1; i < count; i++)
        for (int j = i; j > 0 && p[j].x < p[j - 1].x; j--) {
            ScanPoint q = p[j];
            p[j] = p[j - 1];
            p[j - 1] = q;
        }
}

// Adds the spans of a face on lines first .. end - 1 of a band that begins with line k0.
static void cross_face(Scanner *self, int face, int k0, int first, int end) {
    const ScanFace *f = &self->faces[face];
    int stride = 2 * self->corners + 2, found[SCAN_BAND];
    for (int k = first; k < end; k++) found[k - k0] = 0;
    for (const ScanArc *a = self->arcs + f->first_arc; a < self->arcs + f->first_arc + f->arc_count; a++) {
        int a_first = a->first > first ? a->first : first, a_end = a->end < end ? a->end : end;
        for (int k = a_first; k < a_end; k++) {
            double y = self->lattice.line[k].y, s2 = a->h2 - a->e2 * y * y, s = s2 > 0 ? sqrt(s2) : 0;
            self->crossing[(k - k0) * stride + found[k - k0]++] =
                (ScanPoint){a->a * y + a->b * s, a->c * y + a->e * s};
        }
    }
    for (int line = first - k0; line < end - k0; line++) {
        ScanPoint *p = self->crossing + line * stride;
        sort_points(p, found[line]);
        for (int i = 0; i + 1 < found[line]; i += 2)
            if (p[i].x < p[i + 1].x)
                self->span[self->span_first[line] + self->span_count[line]++] =
                    (ScanSpan){p[i], p[i + 1], face};
    }
}

// Adds a visible span, or a gap (face -1), to the sum.
static void add_span(Scanner *self, const ScanLine *line, const ScanSpan *span, RowSum *sum,
                     FormFactorWork *work) {
    double share = (span->to.x - span->from.x) * line->weight;
    ScanFace *f = span->face >= 0 ? &self->faces[span->face] : NULL;
    work->samples++;
    if (!f) {
        sum->escaped += share;
        return;
    }
    if (f->back) {
        sum->back += share;
        return;
    }
    if (!f->has_grid) {
        f->has_grid = true;
        f->grid = face_grid(self->mesh, self->view, f->face);
        f->axis[0] = scan_axis(turned(f->grid.gx, self->across), f->grid.x0, f->grid.nx, f->inverse);
        f->axis[1] = scan_axis(turned(f->grid.gy, self->across), f->grid.y0, f->grid.ny, f->inverse);
    }
    work->samples += scan_elements(f, line, span, sum);
}

// The next stretch of one face, or of no face, from `at` on; slivers are joined to it.
static ScanSpan next_stretch(const ScanList *list, int *next, ScanPoint at, ScanPoint rim) {
    ScanSpan stretch = {at, at, -2};
    while (stretch.to.x < rim.x) {
        int s = *next;
        const ScanSpan *span = s >= 0 ? &list->span[s] : NULL;
        bool gap = !span || span->from.x > stretch.to.x;
        ScanPoint end = !gap ? span->to : span ? span->from : rim;
        int face = gap ? -1 : span->face;
        bool sliver = end.x - stretch.to.x < SCAN_SLIVER;
        if (stretch.face != -2 && face != stretch.face && !sliver) break;
        if (stretch.face == -2 && !sliver) stretch.face = face;
        if (end.x > stretch.to.x) stretch.to = end;
        if (!gap) *next = list->next[s];
    }
    return stretch;
}

static void see_line(Scanner *self, int k, const ScanSpan *span, int count, RowSum *sum,
                     FormFactorWork *work) {
    const ScanLine *line = &self->lattice.line[k];
    self->list.first = -1;
    self->list.free = -1;
    self->list.count = 0;
    self->list.tests = 0;
    for (int i = 0; i < count; i++) scan_list_add(&self->list, self->faces, line, &span[i]);
    ScanPoint at = {-line->radius, 0}, rim = {line->radius, 0};
    for (int next = self->list.first; at.x < rim.x;) {
        ScanSpan stretch = next_stretch(&self->list, &next, at, rim);
        if (rim.x - stretch.to.x < SCAN_SLIVER) stretch.to = rim;
        add_span(self, line, &stretch, sum, work);
        at = stretch.to;
    }
    work->tests += self->list.tests;
}

// Adds the faces seen along all lines of a lattice; `across`: along the lines the other way.
static void scanner_see(Scanner *self, const ScanLattice *lattice, bool across, RowSum *sum,
                        FormFactorWork *work) {
    self->lattice = *lattice;
    if (across != self->across) turn_corners(self, self->first_corner[self->view->face_count]);
    self->across = across;
    find_faces(self);
    for (int k0 = 0, k1; k0 < lattice->count; k0 = k1) {
        k1 = next_band(self, k0);
        for (int f = 0; f < self->face_count; f++) {
            const ScanFace *face = &self->faces[f];
            int first = face->first_line > k0 ? face->first_line : k0;
            int end = face->end_line < k1 ? face->end_line : k1;
            if (first < end) cross_face(self, f, k0, first, end);
        }
        for (int k = k0; k < k1; k++)
            see_line(self, k, self->span + self->span_first[k - k0], self->span_count[k - k0], sum, work);
    }
}

// ---- how many scan lines, and which ways: one way, both ways, or both ways with as many lines as a patch that shoots needs
// (Doi & Itoh, eq. 8 and section 3: "line sampling of variable kind in the horizontal and vertical directions").
//
// The error falls almost with the square of the number of lines, so n lines one way err half as much as n / 2 lines each of both
// ways. A line's length is weighted with the exact area of its strip, so that rows sum to 1.
//
// The paper does not say how the number of lines is found. Here the two ways are two measurements of one row, and their difference
// estimates the error: each way begins with few lines, and lines are added between them until the two ways differ by no more than
// is allowed. These lines are evenly spaced in the angle t of y = -cos t, because their weights, sin t, then do not depend on the
// final number of lines: the sum of sin^2 t over any even lattice is exactly half the number. This bounds the error of each row, but
// the mean error of many rows is less, in the same time, if all rows take the same number of lines.

enum { MOST_LEVELS = 5 };  // from a quarter of `resolution` lines each way to four times as many
// How much the two ways may differ, as the L1 distance of the rows, times resolution^1.5: chosen so that rows in an office take
// about `resolution` lines each way on average.
static const double DIFFERENCE = 60;
// The positions of the first lines in their strips. However often the strips are halved, the lattices of the two ways never coincide
// and are never mirror images: otherwise a row with equal errors both ways would seem right.
static const double OFFSET[2] = {1.0 / 3, 1.0 / 5};

typedef struct ScanMethod {
    Scanner *scan;
    int ways;  // 1 or 2
    ScanLattice lattice;
} ScanMethod;

// Area below y of the half of the disc where x > 0.
static double area_below(double y) { return (y * sqrt(1 - y * y) + asin(y)) / 2; }

static ScanLine line_at(double y, double weight) {
    double r2 = 1 - y * y;
    return (ScanLine){y, r2, sqrt(r2), weight};
}

static void *scanline_start(const Mesh *mesh, const FormFactorOptions *options, int ways, Arena *arena) {
    ScanMethod *self = ARENA_ARRAY(arena, ScanMethod, 1);
    int lines = options->resolution;
    self->scan = scanner_new(mesh, lines, arena);
    self->ways = ways;
    self->lattice = (ScanLattice){lines, 0.5, false, ARENA_ARRAY(arena, ScanLine, lines)};
    for (int k = 0; k < lines; k++) {
        double y0 = -1 + 2.0 * k / lines, y1 = k + 1 < lines ? -1 + 2.0 * (k + 1) / lines : 1;
        ScanLine *line = &self->lattice.line[k];
        *line = line_at(-1 + (2 * k + 1.0) / lines, (area_below(y1) - area_below(y0)) / (ways * M_PI));
        line->weight /= line->radius;
    }
    return self;
}

static void *start_one_way(const Mesh *mesh, const FormFactorOptions *options, Arena *arena) {
    return scanline_start(mesh, options, 1, arena);
}

static void *start_both_ways(const Mesh *mesh, const FormFactorOptions *options, Arena *arena) {
    return scanline_start(mesh, options, 2, arena);
}

static void scanline_row(void *context, const View *view, RowSum *sum, FormFactorWork *work) {
    const ScanMethod *self = context;
    scanner_look(self->scan, view);
    for (int way = 0; way < self->ways; way++) scanner_see(self->scan, &self->lattice, way == 1, sum, work);
}

// ---- as many lines as a row needs

typedef struct ScanFit {
    Scanner *scan;
    ScanLattice level[MOST_LEVELS]
                     [2];  // of each way; the lines of a level lie between those of all levels before
    double difference;     // the allowed L1 distance
    RowSum across;         // the row from the lines the other way
} ScanFit;

static ScanLattice even_in_angle(int count, double offset, Arena *arena) {
    ScanLattice lattice = {count, offset, true, ARENA_ARRAY(arena, ScanLine, count)};
    for (int k = 0; k < count; k++) {
        double t = M_PI * (k + offset) / count;
        lattice.line[k] = line_at(-cos(t), sin(t));
    }
    return lattice;
}

static void *start_fit(const Mesh *mesh, const FormFactorOptions *options, Arena *arena) {
    ScanFit *self = ARENA_ARRAY(arena, ScanFit, 1);
    int least = (options->resolution + 3) / 4, lines = least;
    for (int way = 0; way < 2; way++) {
        double offset = OFFSET[way];
        self->level[0][way] = even_in_angle(lines = least, offset, arena);
        for (int level = 1; level < MOST_LEVELS; level++, lines *= 2) {
            // The new lines lie midway between the existing lines; all lines together have strips of half the width.
            self->level[level][way] = even_in_angle(lines, fmod(offset + 0.5, 1), arena);
            offset = fmod(2 * offset, 1);
        }
    }
    self->scan = scanner_new(mesh, lines, arena);
    self->difference = DIFFERENCE / pow(options->resolution, 1.5);
    row_start(&self->across, mesh, arena);
    return self;
}

static double total_of(const RowSum *sum) {
    double total = sum->back + sum->escaped;
    for (int i = 0; i < sum->touched_count; i++) total += sum->share[sum->touched[i]];
    return total;
}

// The L1 distance of two rows, as a share of the first row's total.
static double difference_of(const RowSum *a, const RowSum *b) {
    double sum = fabs(a->back - b->back) + fabs(a->escaped - b->escaped);
    for (int i = 0; i < a->touched_count; i++) sum += fabs(a->share[a->touched[i]] - b->share[a->touched[i]]);
    for (int i = 0; i < b->touched_count; i++)
        if (a->share[b->touched[i]] == 0) sum += b->share[b->touched[i]];
    return sum / total_of(a);
}

// Adds the sum `from` to the sum `to`, and empties `from`.
static void move_sum(RowSum *from, RowSum *to) {
    for (int i = 0; i < from->touched_count; i++) {
        int element = from->touched[i];
        row_add(to, element, from->share[element]);
        from->share[element] = 0;
    }
    to->back += from->back, to->escaped += from->escaped;
    from->back = from->escaped = 0;
    from->touched_count = 0;
}

static void row_fit(void *context, const View *view, RowSum *sum, FormFactorWork *work) {
    ScanFit *self = context;
    scanner_look(self->scan, view);
    for (int level = 0; level < MOST_LEVELS; level++) {
        scanner_see(self->scan, &self->level[level][0], false, sum, work);
        scanner_see(self->scan, &self->level[level][1], true, &self->across, work);
        if (difference_of(sum, &self->across) <= self->difference) break;
    }
    move_sum(&self->across, sum);
}

const FormFactorMethod FORM_FACTOR_HEMISPHERE_SCANLINE = {
    .name = "hemisphere-scanline",
    .summary = "lines over the hemisphere's base one way, exact along them",
    .mended = true,
    .start = start_one_way,
    .row = scanline_row,
};

const FormFactorMethod FORM_FACTOR_HEMISPHERE_SCANLINES = {
    .name = "hemisphere-scanlines",
    .summary = "the same both ways (Doi & Itoh), `resolution` lines each",
    .mended = true,
    .start = start_both_ways,
    .row = scanline_row,
};

const FormFactorMethod FORM_FACTOR_HEMISPHERE_SCANLINES_FIT = {
    .name = "hemisphere-scanlines-fit",
    .summary = "the same, as many as a shooter needs, some `resolution` each",
    .mended = true,
    .start = start_fit,
    .row = row_fit,
};
