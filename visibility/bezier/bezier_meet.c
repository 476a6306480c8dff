// bezier_meet.c - where two rational cubics meet, by Bezier clipping (Sederberg & Nishita 1990): the one lies in a strip
// along the line through its ends, its fat line; what lies outside the strip is clipped off the other; and in turn. What does
// not shrink is halved.
#include "visibility/bezier/bezier_meet.h"

#include "visibility/bezier/bernstein.h"

// A curve that keeps more than this is halved (Sederberg & Nishita 1990).
#define SHRINKS 0.8
// Both curves this narrow, in parameter: they meet. Meetings no farther apart than the second are one.
#define NARROWEST 1e-12
#define SAME 1e-9
enum { WAITING = 128, MOST_PAIRS = 4000, CUBIC = 3 };

typedef struct Curve {
    double x[4], y[4], w[4];  // multiplied by their weights
    double low, high;         // of it, in the whole
} Curve;

typedef struct Pair {
    Curve curve[2];
} Pair;

static Curve curve_of(const CurvedTrim *trim) {
    Curve c = {.high = 1};
    for (int i = 0; i < 4; i++) {
        c.w[i] = trim->weight[i];
        c.x[i] = trim->point[i].x * c.w[i];
        c.y[i] = trim->point[i].y * c.w[i];
    }
    return c;
}

static void cut_curve(Curve *c, double low, double high) {
    double width = c->high - c->low, from = c->low;
    bernstein_cut(c->x, CUBIC, low, high);
    bernstein_cut(c->y, CUBIC, low, high);
    bernstein_cut(c->w, CUBIC, low, high);
    c->low = from + low * width;
    c->high = from + high * width;
}

// Clips off what lies outside the strip along `direction` that holds the other curve. False: nothing is left.
static bool clip_curve(Curve *c, const Curve *other, Vec2 direction) {
    Vec2 n = {-direction.y, direction.x};
    double least = INFINITY, most = -INFINITY;
    for (int i = 0; i < 4; i++) {
        double at = (n.x * other->x[i] + n.y * other->y[i]) / other->w[i];
        least = fmin(least, at);
        most = fmax(most, at);
    }
    double slack = 1e-15 * (fabs(least) + fabs(most) + vec2_length(n)), low, high, below[4], above[4];
    for (int side = 0; side < 2; side++) {
        for (int i = 0; i < 4; i++) {
            double at = n.x * c->x[i] + n.y * c->y[i];
            above[i] = at - (least - slack) * c->w[i];
            below[i] = (most + slack) * c->w[i] - at;
        }
        if (!bernstein_clip_above(side ? below : above, CUBIC, &low, &high)) return false;
        if (!(high - low > NARROWEST)) high = fmin(low + NARROWEST, 1), low = high - NARROWEST;
        cut_curve(c, low, high);
    }
    return true;
}

static Vec2 chord(const Curve *c) {
    return vec2_sub(vec2(c->x[3] / c->w[3], c->y[3] / c->w[3]), vec2(c->x[0] / c->w[0], c->y[0] / c->w[0]));
}

// Strips along the other's chord and across it: the second tells curves apart that lie one behind the other.
static bool clip_both(Pair *pair) {
    for (int k = 0; k < 2; k++) {
        Curve *c = &pair->curve[k], *other = &pair->curve[1 - k];
        if (!(c->high - c->low > NARROWEST)) continue;
        Vec2 along = chord(other);
        if (vec2_dot(along, along) == 0) along = vec2(1, 0);
        if (!clip_curve(c, other, along) || !clip_curve(c, other, vec2(-along.y, along.x))) return false;
    }
    return true;
}

static void add_meeting(const Pair *pair, BezierMeeting *out, int *count, int max) {
    BezierMeeting m = {(pair->curve[0].low + pair->curve[0].high) / 2,
                       (pair->curve[1].low + pair->curve[1].high) / 2};
    for (int i = 0; i < *count && i < max; i++)
        if (fabs(out[i].s - m.s) <= SAME && fabs(out[i].t - m.t) <= SAME) return;
    if (*count < max) out[*count] = m;
    ++*count;
}

static double width(const Curve *c) { return c->high - c->low; }

int bezier_meetings(const CurvedTrim *a, const CurvedTrim *b, BezierMeeting *out, int max, CurvedWork *work) {
    Pair waiting[WAITING];
    waiting[0] = (Pair){{curve_of(a), curve_of(b)}};
    int found = 0, count = 1;
    for (int pairs = 0; count > 0; pairs++) {
        if (pairs == MOST_PAIRS || count + 2 > WAITING) {
            work->undecided++;
            break;
        }
        Pair *pair = &waiting[--count];
        double before[2] = {width(&pair->curve[0]), width(&pair->curve[1])};
        work->clips += 4;
        if (!clip_both(pair)) continue;
        double now[2] = {width(&pair->curve[0]), width(&pair->curve[1])};
        if (now[0] <= 2 * NARROWEST && now[1] <= 2 * NARROWEST) {
            add_meeting(pair, out, &found, max);
            continue;
        }
        count++;
        if (now[0] <= SHRINKS * before[0] || now[1] <= SHRINKS * before[1]) continue;
        work->splits++;
        int longer = now[1] > now[0];
        waiting[count] = *pair;
        cut_curve(&pair->curve[longer], 0, 0.5);
        cut_curve(&waiting[count++].curve[longer], 0.5, 1);
    }
    return found;
}
