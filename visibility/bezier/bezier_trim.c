// bezier_trim.c - is a point of a patch inside its trims' loops? A line from it along u crosses them an odd number of times
// (Nishita, Sederberg & Kakimoto 1990, section 4).
//
// Curves are cut, once, where they turn in u or v. Each piece rises or falls in both, so that most pieces are told by the
// box of their ends; of the others the one crossing is found by Bezier clipping. A piece counts from its lower end up to,
// not including, its upper one, and neighbours share their ends: so no line slips through between two curves or counts
// them both.
#include "visibility/bezier/bezier_trim.h"

#include "visibility/bezier/bernstein.h"

// Turning points found within this of a curve's end, of its length in parameter, are that end.
#define AT_AN_END 1e-9
// Pieces are halved so often: the boxes of their ends are smaller then, and more rectangles are free of them.
enum { PIECE_HALVINGS = 2 };

typedef struct Piece {
    double x[4], y[4], w[4];  // multiplied by their weights
    Vec2 end[2];
    Vec2 low, high;  // of the ends, and so of all of it
} Piece;

struct Trim {
    Piece *pieces;
    int count, capacity;
};

static void add_trim_piece(Trim *trim, const Piece *curve, double low, double high, Vec2 start, Vec2 end,
                           Arena *arena) {
    Piece *p = ARENA_PUSH(arena, trim->pieces, trim->count, trim->capacity);
    *p = *curve;
    bernstein_cut(p->x, 3, low, high);
    bernstein_cut(p->y, 3, low, high);
    bernstein_cut(p->w, 3, low, high);
    p->end[0] = start;
    p->end[1] = end;
    p->low = vec2(fmin(start.x, end.x), fmin(start.y, end.y));
    p->high = vec2(fmax(start.x, end.x), fmax(start.y, end.y));
}

// Where x / w turns: the roots of x' w - x w', of degree 4 (the terms of degree 5 cancel).
static int turns_of(const double *x, const double *w, double *root) {
    double a = x[1] * w[0] - x[0] * w[1], b = x[2] * w[0] - x[0] * w[2], c = x[3] * w[0] - x[0] * w[3];
    double d = x[2] * w[1] - x[1] * w[2], e = x[3] * w[1] - x[1] * w[3], f = x[3] * w[2] - x[2] * w[3];
    double turn[5] = {3 * a, 1.5 * b, 0.5 * (c + 3 * d), 1.5 * e, 3 * f};
    CurvedWork work = {0};
    return bernstein_roots(turn, 4, 0, root, 4, &work);
}

static void sort(double *a, int count) {
    for (int i = 1; i < count; i++)
        for (int k = i; k > 0 && a[k - 1] > a[k]; k--) {
            double swap = a[k];
            a[k] = a[k - 1], a[k - 1] = swap;
        }
}

static Vec2 point_at(const Piece *curve, double s) {
    double slope, w = bernstein_value(curve->w, 3, s, &slope);
    return vec2(bernstein_value(curve->x, 3, s, &slope) / w, bernstein_value(curve->y, 3, s, &slope) / w);
}

static void add_curve(Trim *trim, const CurvedTrim *from, Vec2 start, Vec2 end, Arena *arena) {
    Piece curve;
    for (int i = 0; i < 4; i++) {
        curve.w[i] = from->weight[i];
        curve.x[i] = from->point[i].x * curve.w[i];
        curve.y[i] = from->point[i].y * curve.w[i];
    }
    double cut[10] = {0};
    int count = 1;
    count += turns_of(curve.x, curve.w, cut + count);
    count += turns_of(curve.y, curve.w, cut + count);
    sort(cut, count);
    cut[count] = 1;
    double low = 0;
    Vec2 at = start;
    for (int i = 1; i <= count; i++) {
        if (i < count && !(cut[i] > low + AT_AN_END && cut[i] < 1 - AT_AN_END)) continue;
        double from_s = low;
        for (int k = 1; k <= 1 << PIECE_HALVINGS; k++) {
            double high = from_s + (cut[i] - from_s) * k / (1 << PIECE_HALVINGS);
            bool ends = i == count && k == 1 << PIECE_HALVINGS;
            Vec2 next = ends ? end : point_at(&curve, high);
            add_trim_piece(trim, &curve, low, high, at, next, arena);
            low = high;
            at = next;
        }
    }
}

// A loop's last curve ends at the very point at which its first begins, each other where the next one does.
Trim *trim_new(const CurvedTrim *curves, int count, Arena *arena) {
    Trim *trim = ARENA_ARRAY(arena, Trim, 1);
    int first = 0;
    for (int i = 0; i < count; i++) {
        bool last = vec2_equal(curves[i].point[3], curves[first].point[0]);
        Vec2 end = last || i + 1 == count ? curves[first].point[0] : curves[i + 1].point[0];
        add_curve(trim, &curves[i], curves[i].point[0], end, arena);
        if (last) first = i + 1;
    }
    return trim;
}

// Does the piece, which reaches from below `at` to above it, or the other way, cross the line to the right of it?
static bool crosses(const Piece *p, Vec2 at, CurvedWork *work) {
    double y[4], root[3], slope;
    for (int i = 0; i < 4; i++) y[i] = p->y[i] - at.y * p->w[i];
    int count = bernstein_roots(y, 3, 0, root, 3, work);
    // A piece as flat as rounding may have no root: its ends are as near as any other place.
    double s = count > 0 ? root[0] : 0.5;
    return bernstein_value(p->x, 3, s, &slope) > at.x * bernstein_value(p->w, 3, s, &slope);
}

bool trim_keeps(const Trim *trim, Vec2 at, CurvedWork *work) {
    bool inside = false;
    for (int i = 0; i < trim->count; i++) {
        const Piece *p = &trim->pieces[i];
        if (at.y < p->low.y || at.y >= p->high.y || at.x >= p->high.x) continue;
        inside ^= at.x < p->low.x || crosses(p, at, work);
    }
    return inside;
}

int trim_state(const Trim *trim, Vec2 low, Vec2 high) {
    for (int i = 0; i < trim->count; i++) {
        const Piece *p = &trim->pieces[i];
        if (p->low.x <= high.x && p->high.x >= low.x && p->low.y <= high.y && p->high.y >= low.y)
            return TRIM_SOME_KEPT;
    }
    CurvedWork work = {0};
    Vec2 middle = vec2_scale(vec2_add(low, high), 0.5);
    return trim_keeps(trim, middle, &work) ? TRIM_KEPT : TRIM_CUT_OFF;
}
