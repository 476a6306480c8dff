// curve.c - curves as points: polylines, arcs as chords, composite and trimmed curves (ISO 16739, IfcGeometryResource).
#include <strings.h>

#include "maps/ifc/ifc_file.h"

// A curve that ends where it begins is closed.
static void close_curve(Curve *curve) {
    if (curve->count < 3 ||
        vec3_length(vec3_sub(curve->points[0], curve->points[curve->count - 1])) >= IFC_SAME_POINT)
        return;
    curve->count--;
    curve->closed = true;
}

int ifc_chords(const Reader *r, double radius, double angle) {
    double share = radius > IFC_SAGITTA ? 1 - IFC_SAGITTA / radius : 0;
    // A multiple of four of a whole circle, so that its box is that of its chords.
    double whole = fmin(fmax(r->file->options.circle_chords, 4 * ceil(M_PI / acos(share) / 4)), 1e9);
    double chords = ceil(whole * fabs(angle) / (2 * M_PI) - 1e-9);
    if (chords < 2 && fabs(angle) > 0.05) return 2;
    return chords > IFC_MOST_CHORDS ? IFC_MOST_CHORDS : chords > 1 ? (int)chords : 1;
}

static void push_arc(Reader *r, const Frame *f, double a, double b, double from, double angle, Curve *out) {
    int chords = ifc_chords(r, a > b ? a : b, angle);
    bool begins = out->count == 0;
    for (int i = 0; i <= chords; i++) {
        double t = from + angle * i / chords;
        ifc_curve_push(r, out, frame_point(f, vec3(a * cos(t), b * sin(t), 0)));
    }
    Vec3 way[2];
    for (int i = 0; i < 2; i++) {
        double t = i ? from + angle : from;
        way[i] = vec3_normalize(frame_turn(f, vec3(-a * sin(t) * angle, b * cos(t) * angle, 0)));
    }
    if (begins) out->first = way[0];
    out->last = way[1];
}

// ---- trims

typedef struct Trim {
    double parameter;  // NAN: not told
    Vec3 point;
    bool has_point;
} Trim;

static Trim read_trim(Reader *r, const StepValue *list) {
    Trim trim = {.parameter = NAN};
    StepCursor c = ifc_list(r, list);
    for (StepValue v = step_next(&c); v.kind != STEP_END; v = step_next(&c)) {
        if (v.kind == STEP_REF && v.record >= 0) {
            trim.point = ifc_point(r, v.record);
            trim.has_point = true;
        } else {
            double number = ifc_number(r, &v, NAN);
            if (!isnan(number)) trim.parameter = number;
        }
    }
    return trim;
}

// Points and parameters of a trim that lie farther apart than this share of the radius contradict each other.
static const double TRIM_SLACK = 0.01;

// The angle of a trim about a conic's centre. Some files tell degrees where their unit is the radian, or where they have none: a point
// on the conic holds where the parameter leads elsewhere.
static double conic_angle(Reader *r, const Frame *f, double a, double b, const Trim *trim, bool by_point) {
    double told = isnan(trim->parameter) ? 0 : trim->parameter * r->file->angle;
    if (!trim->has_point) return told;
    Vec3 d = vec3_sub(trim->point, f->o);
    Vec2 at = vec2(vec3_dot(d, f->x) / a, vec3_dot(d, f->y) / b),
         off = vec2_sub(at, vec2(cos(told), sin(told)));
    bool on_conic = fabs(vec2_length(at) - 1) < TRIM_SLACK;
    bool point = by_point || isnan(trim->parameter) || (on_conic && vec2_length(off) > TRIM_SLACK);
    return point ? atan2(at.y, at.x) : told;
}

static bool conic(Reader *r, int record, Frame *f, double *a, double *b) {
    StepValue v[3];
    if (!ifc_arguments(r, record, v, 3)) return false;
    *f = ifc_axes(r, v[0].record);
    *a = ifc_length(r, &v[1], 0);
    *b = ifc_type(r, record) == T_ELLIPSE ? ifc_length(r, &v[2], 0) : *a;
    if (!(*a > 0) || !(*b > 0)) {
        ifc_note(r, record, "has no radius above 0");
        return false;
    }
    return true;
}

static bool trimmed_conic(Reader *r, int basis, const Trim trim[2], bool forwards, bool by_point,
                          Curve *out) {
    Frame f;
    double a, b;
    if (!conic(r, basis, &f, &a, &b)) return false;
    double from = conic_angle(r, &f, a, b, &trim[0], by_point),
           to = conic_angle(r, &f, a, b, &trim[1], by_point), turn = 2 * M_PI;
    double angle = remainder(to - from, turn);
    // The same place twice is the whole conic; elsewhere the way goes with the sense.
    bool whole = fabs(angle) < 1e-9;
    if (forwards && (angle < 0 || whole)) angle += turn;
    if (!forwards && (angle > 0 || whole)) angle -= turn;
    if (fabs(angle) > turn) angle = forwards ? turn : -turn;
    push_arc(r, &f, a, b, from, angle, out);
    return true;
}

static bool trimmed_line(Reader *r, int basis, const Trim trim[2], bool by_point, Curve *out) {
    StepValue v[2], w[2];
    if (!ifc_arguments(r, basis, v, 2) || !ifc_arguments(r, v[1].record, w, 2)) return false;
    Vec3 o = ifc_point(r, v[0].record), d = ifc_direction(r, w[0].record, vec3(1, 0, 0));
    d = vec3_scale(d, ifc_length(r, &w[1], 0));
    for (int i = 0; i < 2; i++) {
        bool point = trim[i].has_point && (by_point || isnan(trim[i].parameter));
        ifc_curve_push(r, out,
                       point ? trim[i].point
                             : vec3_add(o, vec3_scale(d, isnan(trim[i].parameter) ? i : trim[i].parameter)));
    }
    return true;
}

// The part of points between two parameters, which count points from 0.
static void trimmed_points(Reader *r, const Curve *points, double from, double to, Curve *out) {
    int count = points->count + points->closed;
    if (count < 2) return;
    for (int i = 0; i + 1 < count; i++) {
        double low = from > i ? from : i, high = to < i + 1 ? to : i + 1;
        if (low > high) continue;
        Vec3 a = points->points[i], b = points->points[(i + 1) % points->count];
        ifc_curve_push(r, out, vec3_lerp(a, b, low - i));
        ifc_curve_push(r, out, vec3_lerp(a, b, high - i));
    }
}

// A closed curve as one that ends where it begins.
static void open_curve(Reader *r, Curve *curve) {
    if (!curve->closed) return;
    Vec3 first = curve->points[0];
    *ARENA_PUSH(&r->scratch, curve->points, curve->count, curve->room) = first;
    curve->closed = false;
}

static void turn_about(Curve *curve) {
    Vec3 first = curve->first;
    curve->first = vec3_scale(curve->last, -1);
    curve->last = vec3_scale(first, -1);
    for (int i = 0, k = curve->count - 1; i < k; i++, k--) {
        Vec3 keep = curve->points[i];
        curve->points[i] = curve->points[k];
        curve->points[k] = keep;
    }
}

static bool trimmed_curve(Reader *r, int record, Curve *out) {
    StepValue v[5];
    ifc_arguments(r, record, v, 5);
    Trim trim[2] = {read_trim(r, &v[1]), read_trim(r, &v[2])};
    bool forwards = !ifc_is(r, &v[3], "F"), by_point = ifc_is(r, &v[4], "CARTESIAN");
    int type = ifc_type(r, v[0].record);
    if (type == T_CIRCLE || type == T_ELLIPSE)
        return trimmed_conic(r, v[0].record, trim, forwards, by_point, out);
    if (type == T_LINE) return trimmed_line(r, v[0].record, trim, by_point, out);
    Curve basis = {0};
    double both[2] = {trim[0].parameter, trim[1].parameter};
    if (type == T_BSPLINECURVEWITHKNOTS || type == T_RATIONALBSPLINECURVEWITHKNOTS ||
        type == T_BSPLINECURVE) {
        bool told = !isnan(both[0]) && !isnan(both[1]);
        if (told && both[0] > both[1]) {
            double keep = both[0];
            both[0] = both[1];
            both[1] = keep;
        }
        if (!ifc_spline_curve(r, v[0].record, told ? both : NULL, &basis)) return false;
    } else {
        Curve whole = {0};
        if (!ifc_curve(r, v[0].record, &whole)) return false;
        if (isnan(both[0]) || isnan(both[1])) {
            basis = whole;
        } else {
            trimmed_points(r, &whole, fmin(both[0], both[1]), fmax(both[0], both[1]), &basis);
        }
    }
    open_curve(r, &basis);
    if (!forwards) turn_about(&basis);
    for (int i = 0; i < basis.count; i++) ifc_curve_push(r, out, basis.points[i]);
    return true;
}

// ---- curves of several parts

static bool composite(Reader *r, int record, Curve *out) {
    StepValue list, v[3];
    ifc_arguments(r, record, &list, 1);
    StepCursor c = ifc_list(r, &list);
    bool good = true;
    for (StepValue s = step_next(&c); s.kind != STEP_END; s = step_next(&c)) {
        Curve part = {0};
        if (!ifc_arguments(r, s.record, v, 3) || !ifc_curve(r, v[2].record, &part)) {
            good = false;
            continue;
        }
        open_curve(r, &part);
        if (ifc_is(r, &v[1], "F")) turn_about(&part);
        // Programs tell the sense of an arc in two ways; where only the other end fits, the part runs the other way.
        if (out->count > 0 && part.count > 1) {
            Vec3 end = out->points[out->count - 1];
            double first = vec3_length(vec3_sub(part.points[0], end)),
                   last = vec3_length(vec3_sub(part.points[part.count - 1], end));
            if (last < 1e-4 && first > 1e-3) turn_about(&part);
        }
        if (out->count == 0) out->first = part.first;
        for (int i = 0; i < part.count; i++) ifc_curve_push(r, out, part.points[i]);
        out->last = part.last;
    }
    return good && out->count > 1;
}

// The circle through three points, as an arc.
static void push_three_point_arc(Reader *r, Vec3 a, Vec3 b, Vec3 c, Curve *out) {
    Vec3 u = vec3_sub(b, a), v = vec3_sub(c, a), n = vec3_cross(u, v);
    double square = vec3_dot(n, n);
    if (square < 1e-24) {
        ifc_curve_push(r, out, a);
        ifc_curve_push(r, out, b);
        ifc_curve_push(r, out, c);
        return;
    }
    Vec3 centre =
        vec3_add(vec3_scale(vec3_cross(v, n), vec3_dot(u, u)), vec3_scale(vec3_cross(n, u), vec3_dot(v, v)));
    centre = vec3_add(a, vec3_scale(centre, 0.5 / square));
    Vec3 x = vec3_sub(a, centre);
    double radius = vec3_length(x);
    Frame f = {.o = centre, .x = vec3_scale(x, 1 / radius), .z = vec3_normalize(n)};
    f.y = vec3_cross(f.z, f.x);
    Vec3 d = vec3_sub(c, centre);
    double angle = atan2(vec3_dot(d, f.y), vec3_dot(d, f.x));
    if (angle <= 0) angle += 2 * M_PI;
    // The turn about n is from a by b to c.
    push_arc(r, &f, radius, radius, 0, angle, out);
}

static bool is_arc(Reader *r, const StepValue *segment) {
    return segment->kind == STEP_TYPED &&
           strncasecmp(r->file->step.text + segment->name, "IFCARCINDEX", 11) == 0;
}

static bool indexed_polycurve(Reader *r, int record, Curve *out) {
    StepValue v[2];
    Vec3 *points;
    ifc_arguments(r, record, v, 2);
    int count = ifc_point_list(r, v[0].record, &points);
    if (v[1].kind != STEP_LIST) {
        for (int i = 0; i < count; i++) ifc_curve_push(r, out, points[i]);
        return count > 1;
    }
    StepCursor c = ifc_list(r, &v[1]);
    for (StepValue s = step_next(&c); s.kind != STEP_END; s = step_next(&c)) {
        StepCursor inner = ifc_list(r, &s);
        StepValue list = step_next(&inner);
        bool arc = is_arc(r, &s);
        StepCursor at = ifc_list(r, &list);
        int index[3], held = 0;
        for (StepValue i = step_next(&at); i.kind != STEP_END; i = step_next(&at)) {
            double number = ifc_number(r, &i, 0);
            if (!(number >= 1 && number <= count)) {
                ifc_note(r, record, "has the index %g (allowed 1 to %d)", number, count);
                return false;
            }
            if (!arc) {
                ifc_curve_push(r, out, points[(int)number - 1]);
            } else if (held < 3) {
                index[held++] = (int)number - 1;
            }
        }
        if (arc && held == 3)
            push_three_point_arc(r, points[index[0]], points[index[1]], points[index[2]], out);
    }
    return out->count > 1;
}

static bool any_curve(Reader *r, int record, Curve *out) {
    StepValue v[2];
    switch (ifc_type(r, record)) {
    case T_POLYLINE: {
        ifc_arguments(r, record, v, 1);
        StepCursor c = ifc_list(r, &v[0]);
        for (StepValue p = step_next(&c); p.kind != STEP_END; p = step_next(&c))
            ifc_curve_push(r, out, ifc_point(r, p.record));
        return out->count > 1;
    }
    case T_INDEXEDPOLYCURVE:
        return indexed_polycurve(r, record, out);
    case T_COMPOSITECURVE:
    case T_2DCOMPOSITECURVE:
        return composite(r, record, out);
    case T_TRIMMEDCURVE:
        return trimmed_curve(r, record, out);
    case T_CIRCLE:
    case T_ELLIPSE: {
        Frame f;
        double a, b;
        if (!conic(r, record, &f, &a, &b)) return false;
        push_arc(r, &f, a, b, 0, 2 * M_PI, out);
        return true;
    }
    case T_LINE: {
        Trim trim[2] = {{.parameter = 0}, {.parameter = 1}};
        return trimmed_line(r, record, trim, false, out);
    }
    case T_BSPLINECURVE:
    case T_BSPLINECURVEWITHKNOTS:
    case T_RATIONALBSPLINECURVEWITHKNOTS:
        return ifc_spline_curve(r, record, NULL, out);
    case T_SURFACECURVE:
    case T_SEAMCURVE:
        ifc_arguments(r, record, v, 1);
        return ifc_curve(r, v[0].record, out);
    case -1:
        ifc_note(r, -1, "a curve is missing");
        return false;
    default:
        ifc_note(r, record, "is no curve that is read");
        return false;
    }
}

bool ifc_curve(Reader *r, int record, Curve *out) {
    if (!ifc_enter(r, record)) return false;
    bool good = any_curve(r, record, out);
    ifc_leave(r);
    if (good) close_curve(out);
    return good;
}

bool ifc_curve_between(Reader *r, int record, double from, double to, Curve *out) {
    int type = ifc_type(r, record);
    Trim trim[2] = {{.parameter = from}, {.parameter = to}};
    StepValue v[2];
    if (from < to && (type == T_CIRCLE || type == T_ELLIPSE)) {
        bool good = trimmed_conic(r, record, trim, true, false, out);
        close_curve(out);
        return good;
    }
    if (from < to && type == T_LINE) return trimmed_line(r, record, trim, false, out);
    Curve whole = {0};
    if (!ifc_curve(r, record, &whole)) return false;
    bool counts_points = type == T_POLYLINE || (type == T_INDEXEDPOLYCURVE &&
                                                ifc_arguments(r, record, v, 2) && v[1].kind != STEP_LIST);
    // From 0 to 1 is the whole: programs that write it so count by the curve's length.
    if (from == 0 && to == 1) counts_points = false;
    if (from < to && counts_points) trimmed_points(r, &whole, from, to, out);
    if (out->count > 1)
        close_curve(out);
    else
        *out = whole;
    return true;
}

double ifc_along(const Curve *curve, Vec3 p, double *far) {
    double best = INFINITY, out = 0;
    for (int i = 0; i + 1 < curve->count; i++) {
        Vec3 a = curve->points[i], d = vec3_sub(curve->points[i + 1], a);
        double t = vec3_dot(vec3_sub(p, a), d) / vec3_dot(d, d);
        t = t < 0 ? 0 : t > 1 ? 1 : t;
        double off = vec3_length(vec3_sub(p, vec3_add(a, vec3_scale(d, t))));
        if (off < best) {
            best = off;
            out = i + t;
        }
    }
    if (far) *far = best;
    return out;
}

// Vertices of an edge lie on its curve within this, metres; otherwise the edge is the whole curve between them.
static const double EDGE_SLACK = 1e-3;

// The places of an edge's ends along its curve; a closed curve is gone around beyond its last point where the edge needs it.
static void edge_places(const Curve *curve, bool closed, Vec3 start, Vec3 end, double place[2]) {
    double far[2], last = curve->count - 1;
    place[0] = ifc_along(curve, start, &far[0]);
    place[1] = ifc_along(curve, end, &far[1]);
    if (curve->count < 2) far[0] = INFINITY;
    if (closed && place[0] > last - 1e-6) place[0] = 0;
    if (closed && place[1] <= place[0] + 1e-6) place[1] += last;
    if (fmax(far[0], far[1]) <= EDGE_SLACK && place[0] < place[1]) return;
    place[0] = 0;
    place[1] = last;
}

bool ifc_edge(Reader *r, int record, Vec3 start, Vec3 end, bool same_sense, Curve *out) {
    int type = ifc_type(r, record), before = out->count;
    if (type == T_CIRCLE || type == T_ELLIPSE) {
        Trim trim[2] = {{NAN, start, true}, {NAN, end, true}};
        return trimmed_conic(r, record, trim, same_sense, true, out);
    }
    if (type != T_LINE && type >= 0) {
        Curve curve = {0};
        double place[2];
        if (!ifc_curve(r, record, &curve)) return false;
        bool closed = curve.closed;
        open_curve(r, &curve);
        if (!same_sense) turn_about(&curve);
        edge_places(&curve, closed, start, end, place);
        ifc_curve_push(r, out, start);
        for (int i = (int)floor(place[0]) + 1; i < place[1] - 1e-6; i++)
            ifc_curve_push(r, out, curve.points[i % (curve.count - 1)]);
        ifc_curve_push(r, out, end);
        return true;
    }
    ifc_curve_push(r, out, start);
    ifc_curve_push(r, out, end);
    return out->count > before;
}
