// curved_trim.c - the part of a patch that its trims leave, as polygons.
//
// The loops become polylines in the parameters and are cut at the lines of a grid. A cell of the grid that no polyline enters is there as
// a whole or not at all. Another is cut into slabs between the heights of all corners in it, and a slab into trapezoids between the edges
// that pass through it; a trapezoid is there where a ray from it crosses the loops an odd number of times. Corners of neighbours that
// lie on a trapezoid's level or upright sides become corners of it, so that there are no gaps.
#include <stdlib.h>

#include "engine/core/polygon.h"

#include "maps/curved/curved_patch.h"
#include "maps/curved/curved_tessellate.h"

enum { MOST_CURVE_STEPS = 32 };  // chords of a trim
enum { MOST_PIECES = 50000 };    // where loops cross each other all over

// A stretch of the polylines that the loops become, in parameters; within a cell of the grid.
typedef struct TrimSegment {
    Vec2 a, b;
} TrimSegment;

typedef struct TrimPiece {
    Vec2 corner[4];
    int count;
} TrimPiece;

typedef struct CurvedTrimmed {
    const CurvedControl *control;
    CurvedControl border[4][4];
    int border_steps[4];
    double tolerance;
    int nu, nv;
    double *u, *v;  // [nu + 1], [nv + 1] the lines of the grid
    TrimSegment *segments;
    TrimPiece *pieces;
    Vec2 *by_u, *by_v;  // [corner_count] all corners of pieces, by u and then v, by v and then u
    int segment_count, segment_capacity, piece_count, piece_capacity, corner_count;
    Arena *arena;
    CurvedMesh *out;
} CurvedTrimmed;

static int by_number(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

// ---- polylines

static double *lines(int n, Arena *arena) {
    double *at = ARENA_ARRAY(arena, double, n + 1);
    for (int i = 0; i <= n; i++) at[i] = curved_step(i, n);
    return at;
}

// Cuts the segment where it passes the lines of the grid.
static void add_segment(CurvedTrimmed *t, Vec2 a, Vec2 b) {
    double cut[2 * CURVED_MOST_STEPS + 4];
    int count = 0;
    for (int i = 0; i <= t->nu; i++)
        if ((t->u[i] - a.x) * (t->u[i] - b.x) < 0) cut[count++] = (t->u[i] - a.x) / (b.x - a.x);
    for (int j = 0; j <= t->nv; j++)
        if ((t->v[j] - a.y) * (t->v[j] - b.y) < 0) cut[count++] = (t->v[j] - a.y) / (b.y - a.y);
    cut[count++] = 1;
    qsort(cut, (size_t)count, sizeof *cut, by_number);
    Vec2 from = a;
    for (int i = 0; i < count; i++) {
        Vec2 to = vec2_add(a, vec2_scale(vec2_sub(b, a), cut[i]));
        to = i + 1 == count ? b : vec2(curved_snap(to.x), curved_snap(to.y));
        if (!vec2_equal(from, to))
            *ARENA_PUSH(t->arena, t->segments, t->segment_count, t->segment_capacity) =
                (TrimSegment){from, to};
        from = to;
    }
}

static Vec2 trim_at(const CurvedTrim *trim, double s) {
    Vec2 at = curved_trim_point(trim, s);
    return vec2(curved_snap(at.x), curved_snap(at.y));
}

// How far the trim's curve on the patch lies off its chords, at their middles.
static double off_chords(const CurvedTrimmed *t, const CurvedTrim *trim, int steps) {
    double worst = 0;
    for (int i = 0; i < steps; i++) {
        Vec2 a = trim_at(trim, (double)i / steps), m = trim_at(trim, (i + 0.5) / steps),
             b = trim_at(trim, (i + 1.0) / steps);
        Vec3 p = curved_patch_point(t->control, a.x, a.y), q = curved_patch_point(t->control, b.x, b.y);
        Vec3 off = vec3_sub(curved_patch_point(t->control, m.x, m.y), vec3_lerp(p, q, 0.5));
        worst = fmax(worst, vec3_length(off));
    }
    return worst;
}

// The border that a trim runs along, or -1.
static int border_of(const CurvedTrim *trim) {
    bool on[4] = {true, true, true, true};
    for (int i = 0; i < 4; i++) {
        on[0] &= trim->point[i].y == 0;
        on[1] &= trim->point[i].x == 1;
        on[2] &= trim->point[i].y == 1;
        on[3] &= trim->point[i].x == 0;
    }
    for (int e = 0; e < 4; e++)
        if (on[e]) return e;
    return -1;
}

static Vec2 on_border(int e, double s) {
    return e == 0 ? vec2(s, 0) : e == 1 ? vec2(1, s) : e == 2 ? vec2(s, 1) : vec2(0, s);
}

// Along a border it takes the border's own points.
static void add_border_trim(CurvedTrimmed *t, const CurvedTrim *trim, int e) {
    Vec2 from = trim_at(trim, 0), end = trim_at(trim, 1);
    double a = e % 2 ? from.y : from.x, b = e % 2 ? end.y : end.x;
    int n = t->border_steps[e];
    for (int k = 1; k < n; k++) {
        double s = curved_step(a < b ? k : n - k, n);
        if ((s - a) * (s - b) >= 0) continue;
        add_segment(t, from, on_border(e, s));
        from = on_border(e, s);
    }
    add_segment(t, from, end);
}

static void add_trim(CurvedTrimmed *t, const CurvedTrim *trim) {
    int e = border_of(trim), steps = 2;
    if (e >= 0) {
        add_border_trim(t, trim, e);
        return;
    }
    while (steps < MOST_CURVE_STEPS && off_chords(t, trim, steps) > t->tolerance) steps *= 2;
    for (int i = 0; i < steps; i++)
        add_segment(t, trim_at(trim, (double)i / steps), trim_at(trim, (i + 1.0) / steps));
}

// ---- trapezoids

static double u_at(const TrimSegment *s, double v) {
    if (v == s->a.y) return s->a.x;
    if (v == s->b.y) return s->b.x;
    return curved_snap(s->a.x + (s->b.x - s->a.x) * (v - s->a.y) / (s->b.y - s->a.y));
}

// An odd number of segments lies to the left.
static bool is_there(const CurvedTrimmed *t, Vec2 p) {
    bool in = false;
    for (int i = 0; i < t->segment_count; i++) {
        const TrimSegment *s = &t->segments[i];
        if ((s->a.y > p.y) == (s->b.y > p.y)) continue;
        double u = s->a.x + (s->b.x - s->a.x) * (p.y - s->a.y) / (s->b.y - s->a.y);
        if (u < p.x) in = !in;
    }
    return in;
}

static bool is_full(const CurvedTrimmed *t) { return t->piece_count >= MOST_PIECES; }

static void add_trim_piece(CurvedTrimmed *t, Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
    const Vec2 given[4] = {a, b, c, d};
    TrimPiece piece = {.count = 0};
    for (int i = 0; i < 4; i++)
        if (!vec2_equal(given[i], given[(i + 1) % 4])) piece.corner[piece.count++] = given[i];
    if (piece.count < 3) return;
    *ARENA_PUSH(t->arena, t->pieces, t->piece_count, t->piece_capacity) = piece;
    t->corner_count += piece.count;
}

typedef struct Levels {
    double *v;
    int count, capacity;
} Levels;

static void add_level(CurvedTrimmed *t, Levels *levels, double v) {
    *ARENA_PUSH(t->arena, levels->v, levels->count, levels->capacity) = v;
}

// Where two segments of a cell cross, their order changes.
static void add_crossing(CurvedTrimmed *t, const TrimSegment *s, const TrimSegment *r, Levels *levels) {
    Vec2 d = vec2_sub(s->b, s->a), e = vec2_sub(r->b, r->a), from = vec2_sub(r->a, s->a);
    double turn = vec2_cross(d, e);
    if (turn == 0) return;
    double x = vec2_cross(from, e) / turn, y = vec2_cross(from, d) / turn;
    if (x > 0 && x < 1 && y > 0 && y < 1) add_level(t, levels, curved_snap(s->a.y + x * d.y));
}

typedef struct Edge {
    double middle;  // u at half the slab's height
    double low, high;
    bool side;  // of the cell, no segment
} Edge;

static int by_middle(const void *a, const void *b) {
    return by_number(&((const Edge *)a)->middle, &((const Edge *)b)->middle);
}

// The sides of the cell and the segments that pass through the slab, by u.
static int find_edges(const CurvedTrimmed *t, int column, double low, double high, const TrimSegment *in,
                      int count, Edge *edges) {
    int n = 0;
    for (int k = 0; k < 2; k++) {
        double side = t->u[column + k];
        edges[n++] = (Edge){side, side, side, true};
    }
    for (int i = 0; i < count; i++) {
        const TrimSegment *s = &in[i];
        if (fmin(s->a.y, s->b.y) > low || fmax(s->a.y, s->b.y) < high) continue;
        double a = u_at(s, low), b = u_at(s, high);
        edges[n++] = (Edge){(a + b) / 2, a, b, false};
    }
    qsort(edges, (size_t)n, sizeof *edges, by_middle);
    return n;
}

// The first gap between edges is asked for; each segment after it changes the answer.
static void add_slab(CurvedTrimmed *t, double low, double high, const Edge *edges, int count) {
    bool known = false, there = false;
    for (int i = 0; i + 1 < count; i++) {
        const Edge *e = &edges[i], *f = &edges[i + 1];
        if (known && !e->side) there = !there;
        if (e->middle == f->middle) continue;
        if (!known) there = is_there(t, vec2((e->middle + f->middle) / 2, (low + high) / 2));
        known = true;
        if (there)
            add_trim_piece(t, vec2(e->low, low), vec2(f->low, low), vec2(f->high, high), vec2(e->high, high));
    }
}

static void add_cell(CurvedTrimmed *t, int i, int j, const TrimSegment *in, int count) {
    Levels levels = {0};
    Edge *edges = ARENA_ARRAY(t->arena, Edge, count + 2);
    for (int k = 0; k < 2; k++) add_level(t, &levels, t->v[j + k]);
    for (int s = 0; s < count; s++) {
        add_level(t, &levels, in[s].a.y);
        add_level(t, &levels, in[s].b.y);
        for (int r = 0; r < s; r++) add_crossing(t, &in[s], &in[r], &levels);
    }
    qsort(levels.v, (size_t)levels.count, sizeof *levels.v, by_number);
    for (int k = 0; k + 1 < levels.count && !is_full(t); k++) {
        double low = levels.v[k], high = levels.v[k + 1];
        if (low < high) add_slab(t, low, high, edges, find_edges(t, i, low, high, in, count, edges));
    }
}

static int line_below(const double *line, int n, double x) {
    int i = 0;
    while (i + 1 < n && line[i + 1] <= x) i++;
    return i;
}

// Segments sorted by their cells.
static void add_cells(CurvedTrimmed *t) {
    int cells = t->nu * t->nv, *first = ARENA_ARRAY(t->arena, int, cells + 2),
        *cell = ARENA_ARRAY(t->arena, int, t->segment_count + 1);
    TrimSegment *sorted = ARENA_ARRAY(t->arena, TrimSegment, t->segment_count + 1);
    for (int i = 0; i < t->segment_count; i++) {
        const TrimSegment *s = &t->segments[i];
        cell[i] = line_below(t->v, t->nv, (s->a.y + s->b.y) / 2) * t->nu +
                  line_below(t->u, t->nu, (s->a.x + s->b.x) / 2);
        first[cell[i] + 2]++;
    }
    for (int c = 0; c < cells; c++) first[c + 2] += first[c + 1];
    for (int i = 0; i < t->segment_count; i++) sorted[first[cell[i] + 1]++] = t->segments[i];
    for (int c = 0; c < cells; c++)
        add_cell(t, c % t->nu, c / t->nu, sorted + first[c], first[c + 1] - first[c]);
}

// Fills `pieces` and `corner_count`; false where there would be too many.
static bool cut_into_pieces(CurvedTrimmed *t) {
    add_cells(t);
    return !is_full(t);
}

// ---- polygons

static int u_then_v(const void *a, const void *b) {
    const Vec2 *p = a, *q = b;
    return p->x != q->x ? by_number(&p->x, &q->x) : by_number(&p->y, &q->y);
}

static int v_then_u(const void *a, const void *b) {
    const Vec2 *p = a, *q = b;
    return p->y != q->y ? by_number(&p->y, &q->y) : by_number(&p->x, &q->x);
}

static void sort_corners(CurvedTrimmed *t) {
    int n = 0;
    t->by_u = ARENA_ARRAY(t->arena, Vec2, t->corner_count);
    t->by_v = ARENA_ARRAY(t->arena, Vec2, t->corner_count);
    for (int i = 0; i < t->piece_count; i++)
        for (int k = 0; k < t->pieces[i].count; k++) t->by_u[n++] = t->pieces[i].corner[k];
    if (n == 0) return;
    memcpy(t->by_v, t->by_u, sizeof(Vec2) * (size_t)n);
    qsort(t->by_u, (size_t)n, sizeof(Vec2), u_then_v);
    qsort(t->by_v, (size_t)n, sizeof(Vec2), v_then_u);
}

static int find_corner(const Vec2 *sorted, int count, Vec2 p, int (*compare)(const void *, const void *)) {
    int low = 0, high = count;
    while (low < high) {
        int middle = (low + high) / 2;
        if (compare(&sorted[middle], &p) < 0) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

// Appends `a` and the corners between it and b.
static void add_side(const CurvedTrimmed *t, Vec2 a, Vec2 b, Vec2 **ring, int *count, int *capacity) {
    *ARENA_PUSH(t->arena, *ring, *count, *capacity) = a;
    if (a.x != b.x && a.y != b.y) return;
    bool level = a.y == b.y;
    int (*compare)(const void *, const void *) = level ? v_then_u : u_then_v;
    const Vec2 *sorted = level ? t->by_v : t->by_u;
    bool up = compare(&a, &b) < 0;
    int i = find_corner(sorted, t->corner_count, a, compare),
        end = find_corner(sorted, t->corner_count, b, compare);
    for (; i != end; i += up ? 1 : -1) {
        Vec2 p = sorted[i], last = (*ring)[*count - 1];
        if (!vec2_equal(p, last) && !vec2_equal(p, b)) *ARENA_PUSH(t->arena, *ring, *count, *capacity) = p;
    }
}

// On a border, as neighbours compute it.
static Vec3 point_at(const CurvedTrimmed *t, Vec2 at) {
    int e = at.y == 0 ? 0 : at.x == 1 ? 1 : at.y == 1 ? 2 : at.x == 0 ? 3 : -1;
    if (e < 0) return curved_patch_point(t->control, at.x, at.y);
    return curved_curve_point(t->border[e], e % 2 ? at.y : at.x);
}

static void add_trimmed_polygon(CurvedTrimmed *t, const TrimPiece *piece) {
    Vec2 *ring = NULL;
    int count = 0, capacity = 0;
    for (int k = 0; k < piece->count; k++)
        add_side(t, piece->corner[k], piece->corner[(k + 1) % piece->count], &ring, &count, &capacity);
    Vec3 *flat = ARENA_ARRAY(t->arena, Vec3, count), *p = ARENA_ARRAY(t->arena, Vec3, count);
    for (int k = 0; k < count; k++) {
        flat[k] = vec3(ring[k].x, ring[k].y, 0);
        p[k] = point_at(t, ring[k]);
    }
    if (count == 4 && piece->count == 4) {
        curved_mesh_add_quad(t->out, t->arena, p);
        return;
    }
    int *triangle = ARENA_ARRAY(t->arena, int, 3 * (count - 2));
    polygon_triangulate(flat, count, triangle);
    for (int k = 0; k < count - 2; k++, triangle += 3)
        curved_mesh_add(t->out, t->arena, (Vec3[]){p[triangle[0]], p[triangle[1]], p[triangle[2]]}, 3, false);
}

void curved_trimmed_mesh(const CurvedControl *control, const CurvedTrim *trims, int trim_count,
                         double tolerance, Arena *arena, CurvedMesh *out) {
    CurvedTrimmed *t = ARENA_ARRAY(arena, CurvedTrimmed, 1);
    *t = (CurvedTrimmed){.control = control, .tolerance = tolerance, .arena = arena, .out = out};
    // A triangle anyhow in a cell may lie twice as far off as half a cell.
    out->tolerance = 2 * curved_patch_steps(control, tolerance / 2, &t->nu, &t->nv);
    t->u = lines(t->nu, arena);
    t->v = lines(t->nv, arena);
    for (int e = 0; e < 4; e++) {
        curved_patch_border(control, e, t->border[e]);
        t->border_steps[e] = curved_border_steps(t->border[e], tolerance);
    }
    for (int i = 0; i < trim_count; i++) add_trim(t, &trims[i]);
    if (!cut_into_pieces(t)) {
        out->tolerance = INFINITY;
        return;
    }
    sort_corners(t);
    for (int i = 0; i < t->piece_count; i++) add_trimmed_polygon(t, &t->pieces[i]);
}
