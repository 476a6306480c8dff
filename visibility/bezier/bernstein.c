// bernstein.c - roots of polynomials by Bezier clipping (Nishita, Sederberg & Kakimoto 1990, section 2; Sederberg & Nishita
// 1990): what lies outside the convex hull's meeting with the axis is cut off, what does not shrink is halved. Departure:
// as soon as the coefficients only rise or only fall there is one root, which Newton's steps find within its bracket.
#include "visibility/bezier/bernstein.h"

#include <string.h>

// A piece that keeps more than this after a clip is halved (Nishita, Sederberg & Kakimoto 1990).
#define SHRINKS 0.8
// Pieces that are no wider than this and still neither without root nor monotone hold a double root, 2^-28: it is lost in
// rounding at the square root of that of a double.
#define NARROWEST 3.7e-9
// A multiple root is no wider than this: the sixth root of rounding is no place to look for one.
#define WIDEST 1e-4
// Pieces waiting. Each level of halving leaves one, and there are 28.
enum { WAITING = 40 };
// A root of degree 6 takes less than 60; six at once are not twice as far.
enum { MOST_PIECES = 400 };
// The rounding of a root.
#define ROOT_ROUNDING 1e-16
enum { MOST_STEPS = 60 };  // of Newton's, or halvings of its bracket

// The mean of two polynomials of one degree less, whose difference is the slope; each by a Horner scheme of positive shares.
double bernstein_value(const double *c, int degree, double s, double *slope) {
    double r = 1 - s, first = c[0], second = c[1], share = 1;
    for (int i = 1; i < degree; i++) {
        share *= s * (degree - i) / i;
        first = first * r + share * c[i];
        second = second * r + share * c[i + 1];
    }
    *slope = degree * (second - first);
    return r * first + s * second;
}

void bernstein_cut(double *c, int degree, double low, double high) {
    if (high < 1)
        for (int level = 1; level <= degree; level++)
            for (int i = degree; i >= level; i--) c[i] = c[i - 1] + high * (c[i] - c[i - 1]);
    double s = low / high;
    if (low > 0)
        for (int level = 1; level <= degree; level++)
            for (int i = 0; i <= degree - level; i++) c[i] += s * (c[i + 1] - c[i]);
}

// Towards one end: the first place from c[0] on at which the hull comes down to 0, in steps of one coefficient.
static double comes_down(const double *c, int degree, int stride) {
    double first = degree;
    for (int j = 1; j <= degree; j++) {
        double below = c[j * stride];
        if (!(below <= 0)) continue;
        for (int i = 0; i < j; i++) {
            double above = c[i * stride];
            if (!(above > 0)) continue;
            double at = i + (j - i) * (above / (above - below));
            first = at < first ? at : first;
        }
    }
    return first;
}

// Where the convex hull of (i / degree, c[i]) meets the band |y| <= slack: no root lies elsewhere. False: nowhere.
static bool clip_hull(const double *c, int degree, double slack, double *low, double *high) {
    double least = c[0], most = c[0];
    for (int i = 1; i <= degree; i++) {
        least = c[i] < least ? c[i] : least;
        most = c[i] > most ? c[i] : most;
    }
    if (!(least <= slack && most >= -slack)) return false;
    double b[BERNSTEIN_DEGREE + 1] = {0};
    for (int end = 0; end < 2; end++) {
        double first = c[end ? degree : 0], sign = first > 0 ? 1 : -1;
        for (int i = 0; i <= degree; i++) b[i] = sign * c[i] - slack;
        double way =
            b[end ? degree : 0] <= 0 ? 0 : comes_down(end ? b + degree : b, degree, end ? -1 : 1) / degree;
        *(end ? high : low) = end ? 1 - way : way;
    }
    return true;
}

// The root of coefficients that only rise or only fall, between ends of different signs. Newton's steps end where the next
// would be less than rounding, as the last two tell: they fall as squares.
static double monotone_root(const double *c, int degree, CurvedWork *work) {
    double low = 0, high = 1, before = 1, slope, s = c[0] / (c[0] - c[degree]);
    double rising = c[degree] > c[0] ? 1 : -1;
    for (int i = 0; i < MOST_STEPS; i++) {
        double value = rising * bernstein_value(c, degree, s, &slope);
        work->steps++;
        if (value == 0) break;
        *(value > 0 ? &high : &low) = s;
        double next = s - value / (rising * slope);
        if (!(next > low && next < high)) next = (low + high) / 2;
        double step = fabs(next - s);
        s = next;
        if (next == low || next == high || step * step * step <= ROOT_ROUNDING * before * before) break;
        before = step;
    }
    return s;
}

static bool is_monotone(const double *c, int degree) {
    bool rises = true, falls = true;
    for (int i = 0; i < degree; i++) rises &= c[i + 1] >= c[i], falls &= c[i + 1] <= c[i];
    return rises != falls;
}

typedef struct Piece {
    double c[BERNSTEIN_DEGREE + 1];
    double low, high;  // of it, in the whole
} Piece;

static void cut_piece(Piece *p, int degree, double low, double high) {
    double width = p->high - p->low, from = p->low;
    bernstein_cut(p->c, degree, low, high);
    p->low = from + low * width;
    p->high = from + high * width;
}

typedef struct Roots {
    const double *c;  // of the whole
    int degree;
    double slack;
    double *root;
    int count, max;
    double from, to;  // the places that the last root may lie at
} Roots;

// Does the polynomial not leave the slack between two places?
static bool stays_zero(const Roots *roots, double from, double to) {
    if (to - from <= NARROWEST) return true;
    double slope;
    return to - from <= WIDEST &&
           fabs(bernstein_value(roots->c, roots->degree, (from + to) / 2, &slope)) <= roots->slack;
}

// A root where two pieces meet, and one that is as wide as rounding has it, is found in several.
static void add_root(Roots *roots, double low, double high) {
    if (roots->count > 0 && stays_zero(roots, roots->to, low)) {
        roots->to = fmax(roots->to, high);
        roots->root[roots->count - 1] = (roots->from + roots->to) / 2;
    } else if (roots->count < roots->max) {
        roots->root[roots->count++] = (low + high) / 2;
        roots->from = low;
        roots->to = high;
    }
}

static bool is_zero(const double *c, int degree, double slack) {
    for (int i = 0; i <= degree; i++)
        if (!(fabs(c[i]) <= slack)) return false;
    return true;
}

// Clips a piece until it is empty or a root or must be halved. True: halve it.
static bool clip_root_piece(Piece *p, int degree, double slack, Roots *roots, CurvedWork *work) {
    for (;;) {
        double low = 0, high = 1;
        if (!clip_hull(p->c, degree, slack, &low, &high)) return false;
        if (p->high - p->low <= NARROWEST || is_zero(p->c, degree, slack)) {
            add_root(roots, p->low, p->high);
            return false;
        }
        if (is_monotone(p->c, degree) && p->c[0] * p->c[degree] <= 0) {
            double s = p->low + monotone_root(p->c, degree, work) * (p->high - p->low);
            add_root(roots, s, s);
            return false;
        }
        work->clips++;
        if (high - low > SHRINKS) return true;
        if (!(high > low)) {  // a single place: an end of the piece, or where the hull touches
            add_root(roots, p->low + low * (p->high - p->low), p->low + low * (p->high - p->low));
            return false;
        }
        cut_piece(p, degree, low, high);
    }
}

int bernstein_roots(const double *c, int degree, double slack, double *root, int max, CurvedWork *work) {
    Piece waiting[WAITING];
    Roots roots = {.c = c, .degree = degree, .slack = slack, .root = root, .max = max};
    int count = 1;
    waiting[0] = (Piece){.low = 0, .high = 1};
    memcpy(waiting[0].c, c, sizeof *c * (size_t)(degree + 1));
    for (int pieces = 0; count > 0; pieces++) {
        if (roots.count == max && waiting[count - 1].low - roots.to > WIDEST) break;
        if (pieces == MOST_PIECES || count + 2 > WAITING) {
            work->undecided++;
            break;
        }
        Piece p = waiting[--count];
        if (!clip_root_piece(&p, degree, slack, &roots, work)) continue;
        work->splits++;
        waiting[count] = waiting[count + 1] = p;
        cut_piece(&waiting[count++], degree, 0.5, 1);
        cut_piece(&waiting[count++], degree, 0, 0.5);
    }
    return roots.count;
}
