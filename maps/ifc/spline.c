// spline.c - B-spline curves and surfaces, rational ones too (C. de Boor 1972, "On calculating with B-splines"). The parameters of a point
// of a surface are found by Newton's method for least squares from the nearest of a grid of points.
#include "maps/ifc/ifc_file.h"

enum { MOST_DEGREE = 16, MOST_POINTS = 100000, LOOKS_A_SPAN = 8, SEEDS_A_SPAN = 4, MOST_SEEDS = 33 };

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

// Blends the points of one span, each times its weight: those of the parameter end as the last ones.
static void blend(Vec3 *p, double *w, const double *knots, int degree, int span, double t) {
    for (int level = 1; level <= degree; level++) {
        for (int i = degree; i >= level; i--) {
            double low = knots[span - degree + i], high = knots[span + 1 + i - level],
                   share = high > low ? (t - low) / (high - low) : 0;
            p[i] = vec3_lerp(p[i - 1], p[i], share);
            w[i] = w[i - 1] + (w[i] - w[i - 1]) * share;
        }
    }
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
    blend(p, w, knots, degree, span, t);
    return w[degree] != 0 ? vec3_scale(p[degree], 1 / w[degree]) : p[degree];
}

static double angle_between(Vec3 a, Vec3 b) { return atan2(vec3_length(vec3_cross(a, b)), vec3_dot(a, b)); }

// Into how many parts a curve is cut that turns by so much on this length: each turns by no more than a chord of a circle, and lies off
// its chord by no more than a chord may.
static double parts_of(const Reader *r, double turn, double length) {
    double parts = turn * r->file->options.circle_chords / (2 * M_PI),
           far = sqrt(length * turn / (8 * IFC_SAGITTA));
    return fmin(fmax(parts, far), IFC_MOST_CHORDS);
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
        int chords = 1;
        if (n > 1) {
            Vec3 p[LOOKS_A_SPAN + 1];
            double turn = 0, length = 0;
            for (int k = 0; k <= LOOKS_A_SPAN; k++) {
                p[k] = evaluate(points, weights, knots, n, count, low + (high - low) * k / LOOKS_A_SPAN);
                if (k > 0) length += vec3_length(vec3_sub(p[k], p[k - 1]));
                if (k > 1) turn += angle_between(vec3_sub(p[k], p[k - 1]), vec3_sub(p[k - 1], p[k - 2]));
            }
            // Seven turns were seen of eight.
            turn *= (double)LOOKS_A_SPAN / (LOOKS_A_SPAN - 1);
            chords = (int)fmax(2, ceil(parts_of(r, turn, length)));
        }
        for (int k = 0; k <= chords; k++)
            ifc_curve_push(r, out,
                           evaluate(points, weights, knots, n, count, low + (high - low) * k / chords));
    }
    return out->count > 1;
}

// ---- surfaces

Vec3 ifc_spline_point(const SplineSurface *s, Vec2 at) {
    double t[2] = {at.x, at.y};
    int span[2], n = s->degree[0], m = s->degree[1];
    for (int d = 0; d < 2; d++) {
        double from = s->knots[d][s->degree[d]], to = s->knots[d][s->count[d]];
        if (s->closed[d]) t[d] -= floor(t[d]);
        t[d] = from + (to - from) * fmin(fmax(t[d], 0), 1);
        span[d] = find_span(s->knots[d], s->degree[d], s->count[d], t[d]);
    }
    Vec3 row[MOST_DEGREE + 1], p[MOST_DEGREE + 1];
    double row_weight[MOST_DEGREE + 1], w[MOST_DEGREE + 1];
    for (int i = 0; i <= n; i++) {
        int first = (span[0] - n + i) * s->count[1] + span[1] - m;
        for (int k = 0; k <= m; k++) {
            w[k] = s->weights[first + k];
            p[k] = vec3_scale(s->points[first + k], w[k]);
        }
        blend(p, w, s->knots[1], m, span[1], t[1]);
        row[i] = p[m];
        row_weight[i] = w[m];
    }
    blend(row, row_weight, s->knots[0], n, span[0], t[0]);
    return row_weight[n] != 0 ? vec3_scale(row[n], 1 / row_weight[n]) : row[n];
}

// The derivatives by both parameters, as differences towards the middle.
static void slopes(const SplineSurface *s, Vec2 at, Vec3 here, Vec3 out[2]) {
    static const double STEP = 1e-6;
    double u = at.x > 0.5 ? -STEP : STEP, v = at.y > 0.5 ? -STEP : STEP;
    out[0] = vec3_scale(vec3_sub(ifc_spline_point(s, vec2(at.x + u, at.y)), here), 1 / u);
    out[1] = vec3_scale(vec3_sub(ifc_spline_point(s, vec2(at.x, at.y + v)), here), 1 / v);
}

static double within(double t, bool closed) { return closed ? t - floor(t) : fmin(fmax(t, 0), 1); }

// Seeds lie within the surface: at a pole one parameter would never change.
static Vec2 seed_at(const SplineSurface *s, int i) {
    return vec2((i / s->seeds[1] + 0.5) / s->seeds[0], (i % s->seeds[1] + 0.5) / s->seeds[1]);
}

int ifc_spline_pole(const SplineSurface *s, Vec3 p) {
    for (int i = 0; i < 4; i++)
        if (s->is_pole[i] && vec3_length(vec3_sub(p, s->pole[i])) < IFC_SAME_POINT) return i;
    return -1;
}

Vec2 ifc_spline_nearest(const SplineSurface *s, Vec3 p) {
    double best = INFINITY;
    Vec2 at = {0, 0};
    for (int i = 0; i < s->seeds[0] * s->seeds[1]; i++) {
        double far = vec3_length(vec3_sub(s->seed[i], p));
        if (far >= best) continue;
        best = far;
        at = seed_at(s, i);
    }
    for (int turn = 0; turn < 30; turn++) {
        Vec3 here = ifc_spline_point(s, at), d[2], off = vec3_sub(p, here);
        slopes(s, at, here, d);
        double a = vec3_dot(d[0], d[0]), b = vec3_dot(d[0], d[1]), c = vec3_dot(d[1], d[1]),
               x = vec3_dot(d[0], off), y = vec3_dot(d[1], off), size = a * c - b * b;
        // At a pole one derivative is 0: its parameter stays.
        if (!(size > 1e-14 * (a + c) * (a + c))) {
            size = (a + c) * (a + c);
            a += 1e-6 * sqrt(size);
            c += 1e-6 * sqrt(size);
            size = a * c - b * b;
        }
        if (!(size > 0)) break;
        Vec2 step = vec2((x * c - y * b) / size, (y * a - x * b) / size), next = at;
        double far = INFINITY;
        for (int half = 0; half < 8; half++, step = vec2_scale(step, 0.5)) {
            next = vec2(within(at.x + step.x, s->closed[0]), within(at.y + step.y, s->closed[1]));
            far = vec3_length(vec3_sub(ifc_spline_point(s, next), p));
            if (far < best) break;
        }
        if (far >= best) break;
        best = far;
        at = next;
    }
    return at;
}

// Is the surface closed in a direction: do its two ends lie on each other?
static bool ends_meet(const SplineSurface *s, int d) {
    bool apart = false;
    for (int i = 0; i <= 8; i++) {
        double t = i / 8.0;
        Vec3 a = ifc_spline_point(s, d == 0 ? vec2(0, t) : vec2(t, 0)),
             b = ifc_spline_point(s, d == 0 ? vec2(1, t) : vec2(t, 1)),
             half = ifc_spline_point(s, d == 0 ? vec2(0.5, t) : vec2(t, 0.5));
        if (vec3_length(vec3_sub(a, b)) > IFC_SAME_POINT) return false;
        apart |= vec3_length(vec3_sub(a, half)) > IFC_SAME_POINT;
    }
    return apart;
}

// Into how many parts each span is cut in a direction, by how much the surface's normal turns along it.
static void find_spans(Reader *r, SplineSurface *s, int d) {
    int n = s->degree[d], count = s->count[d];
    const double *knots = s->knots[d];
    s->spans[d] = 0;
    s->span[d] = ARENA_ARRAY(&r->scratch, SplineSpan, count - n);
    for (int i = n; i < count; i++) {
        if (!(knots[i] < knots[i + 1])) continue;
        double whole = knots[count] - knots[n], low = (knots[i] - knots[n]) / whole,
               high = (knots[i + 1] - knots[n]) / whole, parts = 1;
        for (int k = 0; k <= 4; k++) {
            double turn = 0, length = 0;
            Vec3 last = {0, 0, 0}, last_normal = {0, 0, 0};
            for (int j = 0; j <= 8; j++) {
                // Not at the very ends, where the next span's normal may be another.
                double t = low + (high - low) * (j == 0 ? 1e-4 : j == 8 ? 1 - 1e-4 : j / 8.0);
                Vec2 at = d == 0 ? vec2(t, k / 4.0) : vec2(k / 4.0, t);
                Vec3 p = ifc_spline_point(s, at), slope[2];
                slopes(s, at, p, slope);
                Vec3 normal = vec3_cross(slope[0], slope[1]);
                if (j > 0) {
                    length += vec3_length(vec3_sub(p, last));
                    turn += angle_between(normal, last_normal);
                }
                last = p;
                last_normal = normal;
            }
            parts = fmax(parts, parts_of(r, turn, length));
        }
        s->span[d][s->spans[d]++] = (SplineSpan){low, high, parts};
    }
}

// The work of finding spans and the parameters of some points, in steps of blending.
static double work_of(const SplineSurface *s, int points) {
    int n = s->degree[0], m = s->degree[1];
    double steps = (n + 1) * (m * (m + 1) / 2.0 + 1) + n * (n + 1) / 2.0;
    return steps * (150.0 * (s->count[0] + s->count[1]) + 25.0 * points + MOST_SEEDS * MOST_SEEDS);
}

bool ifc_spline_surface(Reader *r, int record, int points, SplineSurface *s) {
    StepValue v[13];
    ifc_arguments(r, record, v, 13);
    int room = 0, total = 0, rows = 0;
    *s = (SplineSurface){0};
    StepCursor c = ifc_list(r, &v[2]);
    for (StepValue row = step_next(&c); row.kind != STEP_END; row = step_next(&c), rows++) {
        StepCursor inner = ifc_list(r, &row);
        int before = total;
        for (StepValue p = step_next(&inner); p.kind != STEP_END && total < MOST_POINTS;
             p = step_next(&inner))
            *ARENA_PUSH(&r->scratch, s->points, total, room) = ifc_point(r, p.record);
        if (rows > 0 && total - before != s->count[1]) return false;
        s->count[1] = total - before;
    }
    s->count[0] = rows;
    s->weights = ARENA_ARRAY(&r->scratch, double, total + 1);
    for (int i = 0; i < total; i++) s->weights[i] = 1;
    if (ifc_type(r, record) == T_RATIONALBSPLINESURFACEWITHKNOTS) {
        c = ifc_list(r, &v[12]);
        for (int i = 0; i < rows; i++) {
            StepValue row = step_next(&c);
            if (step_numbers(&c, &row, s->weights + (size_t)i * s->count[1], s->count[1]) != s->count[1])
                return false;
        }
    }
    for (int d = 0; d < 2; d++) {
        double degree = ifc_number(r, &v[d], 0);
        if (!(degree >= 1 && degree <= MOST_DEGREE && degree < s->count[d])) return false;
        s->degree[d] = (int)degree;
        s->knots[d] = read_knots(r, &v[7 + d], &v[9 + d], s->count[d] + s->degree[d] + 1);
        if (!s->knots[d] || !(s->knots[d][s->degree[d]] < s->knots[d][s->count[d]])) return false;
    }
    ifc_count_polygons(r, (int)fmin(1e9, work_of(s, points) / IFC_WORK));
    if (ifc_too_many(r)) return false;
    for (int d = 0; d < 2; d++) s->closed[d] = ends_meet(s, d);
    for (int d = 0; d < 2; d++) {
        find_spans(r, s, d);
        s->seeds[d] = SEEDS_A_SPAN * s->spans[d] + 4;
        if (s->seeds[d] > MOST_SEEDS) s->seeds[d] = MOST_SEEDS;
    }
    s->seed = ARENA_ARRAY(&r->scratch, Vec3, s->seeds[0] * s->seeds[1]);
    for (int i = 0; i < s->seeds[0] * s->seeds[1]; i++) s->seed[i] = ifc_spline_point(s, seed_at(s, i));
    for (int i = 0; i < 4; i++) {
        double end = i % 2;
        s->pole[i] = ifc_spline_point(s, i < 2 ? vec2(0, end) : vec2(end, 0));
        s->is_pole[i] = true;
        for (int k = 1; k <= 8 && s->is_pole[i]; k++) {
            Vec3 p = ifc_spline_point(s, i < 2 ? vec2(k / 8.0, end) : vec2(end, k / 8.0));
            s->is_pole[i] = vec3_length(vec3_sub(p, s->pole[i])) < IFC_SAME_POINT;
        }
    }
    return true;
}
