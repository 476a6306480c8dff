// spline.c - B-spline curves, rational ones too, as points (C. de Boor 1972, "On calculating with B-splines").
#include "maps/ifc/ifc_file.h"

enum { MOST_DEGREE = 16, MOST_POINTS = 100000, CHORDS_A_SPAN = 8 };

// Knots, each as often as its multiplicity says; NULL where they do not fit.
static double *read_knots(Reader *r, const StepValue *multiplicities, const StepValue *knots, int wanted) {
    double *out = ARENA_ARRAY(&r->scratch, double, wanted + 1);
    StepCursor m = ifc_list(r, multiplicities), k = ifc_list(r, knots);
    int count = 0;
    for (StepValue times = step_next(&m); times.kind != STEP_END; times = step_next(&m)) {
        StepValue knot = step_next(&k);
        double number = ifc_number(r, &times, 0), value = ifc_number(r, &knot, 0);
        if (!(number >= 1 && number <= wanted - count) || (count > 0 && value < out[count - 1])) return NULL;
        for (int i = 0; i < (int)number; i++) out[count++] = value;
    }
    return count == wanted ? out : NULL;
}

static int find_span(const double *knots, int degree, int count, double t) {
    int low = degree, high = count - 1;
    while (low < high) {
        int middle = (low + high + 1) / 2;
        if (knots[middle] <= t) {
            low = middle;
        } else {
            high = middle - 1;
        }
    }
    return low;
}

static Vec3 evaluate(const Vec3 *points, const double *weights, const double *knots, int degree, int count,
                     double t) {
    int span = find_span(knots, degree, count, t);
    Vec3 p[MOST_DEGREE + 1];
    double w[MOST_DEGREE + 1];
    for (int i = 0; i <= degree; i++) {
        w[i] = weights[span - degree + i];
        p[i] = vec3_scale(points[span - degree + i], w[i]);
    }
    for (int level = 1; level <= degree; level++) {
        for (int i = degree; i >= level; i--) {
            double low = knots[span - degree + i], high = knots[span + 1 + i - level],
                   share = high > low ? (t - low) / (high - low) : 0;
            p[i] = vec3_lerp(p[i - 1], p[i], share);
            w[i] = w[i - 1] + (w[i] - w[i - 1]) * share;
        }
    }
    return w[degree] != 0 ? vec3_scale(p[degree], 1 / w[degree]) : p[degree];
}

bool ifc_spline_curve(Reader *r, int record, const double *trim, Curve *out) {
    StepValue v[9];
    ifc_arguments(r, record, v, 9);
    double degree = ifc_number(r, &v[0], 0);
    int count = 0, room = 0;
    Vec3 *points = NULL;
    StepCursor c = ifc_list(r, &v[1]);
    for (StepValue p = step_next(&c); p.kind != STEP_END && count < MOST_POINTS; p = step_next(&c))
        *ARENA_PUSH(&r->scratch, points, count, room) = ifc_point(r, p.record);
    if (!(degree >= 1 && degree <= MOST_DEGREE && degree < count)) {
        ifc_note(r, record, "has the degree %g and %d points (allowed: degrees 1 to %d, and more points)",
                 degree, count, MOST_DEGREE);
        return false;
    }
    int n = (int)degree;
    double *weights = ARENA_ARRAY(&r->scratch, double, count), *knots;
    for (int i = 0; i < count; i++) weights[i] = 1;
    if (ifc_type(r, record) == T_RATIONALBSPLINECURVEWITHKNOTS) step_numbers(&c, &v[8], weights, count);
    if (ifc_type(r, record) == T_BSPLINECURVE) {
        knots = ARENA_ARRAY(&r->scratch, double, count + n + 1);
        for (int i = 0; i <= count + n; i++) knots[i] = i < n ? 0 : i > count ? count - n : i - n;
    } else {
        knots = read_knots(r, &v[5], &v[6], count + n + 1);
    }
    if (!knots) {
        ifc_note(r, record, "has knots that do not fit its %d points of degree %d", count, n);
        return false;
    }
    double from = knots[n], to = knots[count];
    if (trim) {
        from = fmax(from, trim[0]);
        to = fmin(to, trim[1]);
    }
    for (int i = n; i < count; i++) {
        double low = fmax(knots[i], from), high = fmin(knots[i + 1], to);
        if (!(low < high)) continue;
        int chords = n == 1 ? 1 : CHORDS_A_SPAN;
        for (int k = 0; k <= chords; k++)
            ifc_curve_push(r, out,
                           evaluate(points, weights, knots, n, count, low + (high - low) * k / chords));
    }
    return out->count > 1;
}
