// sh3d_shape.c - the outlines of holes, written as SVG paths (W3C SVG 1.1, section 8.3, arcs by its appendix
// F.6.5). Departures: smooth curves (S, T) are not read, and of several figures the largest counts.
#include <ctype.h>
#include <stdlib.h>
#include <string.h>

#include "maps/sweethome/sh3d.h"

static const int CURVE_STEPS = 8;                // chords of one Bezier curve: they bound small ornaments
static const double ARC_STEP = 15 * M_PI / 180;  // a chord's share of an arc: 0.9 % of the radius off at most

typedef struct Path {
    const char *at;
    Vec2 *out, best[SH3D_MAX_SHAPE];
    int max, count, best_count;
    Vec2 here, start;
    bool failed;
} Path;

double sh3d_shape_area(const Vec2 *points, int count) {
    double area = 0;
    for (int i = 0; i < count; i++) area += vec2_cross(points[i], points[(i + 1) % count]) / 2;
    return area;
}

static void skip(Path *p) {
    while (isspace((unsigned char)*p->at) || *p->at == ',') p->at++;
}

static bool number_follows(Path *p) {
    skip(p);
    return isdigit((unsigned char)*p->at) || (*p->at && strchr("+-.", *p->at));
}

static double number(Path *p) {
    char *stop;
    skip(p);
    double value = strtod(p->at, &stop);
    // Beyond these a unit square has nothing to say, and sums would overflow.
    if (stop == p->at || !(fabs(value) < 1e6)) {
        p->failed = true;
        return 0;
    }
    p->at = stop;
    return value;
}

// Flags may stand without a blank after them.
static bool flag(Path *p) {
    skip(p);
    if (*p->at != '0' && *p->at != '1') p->failed = true;
    return *p->at ? *p->at++ == '1' : false;
}

static Vec2 point(Path *p, bool relative) {
    double x = number(p), y = number(p);
    return relative ? vec2_add(p->here, vec2(x, y)) : vec2(x, y);
}

static void append_to_path(Path *p, Vec2 to) {
    p->here = to;
    if (p->count > 0 && vec2_length(vec2_sub(p->out[p->count - 1], to)) < 1e-9) return;
    if (p->count == p->max) {
        p->failed = true;
        return;
    }
    p->out[p->count++] = to;
}

static void close_figure(Path *p) {
    while (p->count > 1 && vec2_length(vec2_sub(p->out[p->count - 1], p->out[0])) < 1e-9) p->count--;
    if (p->count >= 3 &&
        fabs(sh3d_shape_area(p->out, p->count)) > fabs(sh3d_shape_area(p->best, p->best_count))) {
        memcpy(p->best, p->out, sizeof(Vec2) * (size_t)p->count);
        p->best_count = p->count;
    }
    p->count = 0;
    p->here = p->start;
}

static void cubic(Path *p, Vec2 b, Vec2 c, Vec2 d) {
    Vec2 a = p->here;
    for (int i = 1; i <= CURVE_STEPS; i++) {
        double t = (double)i / CURVE_STEPS, u = 1 - t;
        double wa = u * u * u, wb = 3 * u * u * t, wc = 3 * u * t * t, wd = t * t * t;
        append_to_path(
            p, vec2(wa * a.x + wb * b.x + wc * c.x + wd * d.x, wa * a.y + wb * b.y + wc * c.y + wd * d.y));
    }
}

static void arc(Path *p, double rx, double ry, double turn, bool large, bool sweep, Vec2 to) {
    Vec2 from = p->here;
    rx = fabs(rx), ry = fabs(ry);
    if (rx < 1e-9 || ry < 1e-9) {
        append_to_path(p, to);
        return;
    }
    // In the frame of the ellipse scaled to a circle of radius 1.
    double c = cos(turn), s = sin(turn);
    Vec2 half = vec2_scale(vec2_sub(from, to), 0.5);
    Vec2 q = vec2((c * half.x + s * half.y) / rx, (c * half.y - s * half.x) / ry);
    double away = vec2_dot(q, q);
    if (away < 1e-18) return;
    double scale = away > 1 ? sqrt(away) : 1, h = sqrt(fmax(0, 1 / fmin(away, 1) - 1));
    if (large == sweep) h = -h;
    if (away > 1) q = vec2_scale(q, 1 / scale), rx *= scale, ry *= scale, h = 0;
    Vec2 centre = vec2(h * q.y, -h * q.x);
    double a0 = atan2(q.y - centre.y, q.x - centre.x), a1 = atan2(-q.y - centre.y, -q.x - centre.x);
    double span = a1 - a0;
    if (sweep && span < 0) span += 2 * M_PI;
    if (!sweep && span > 0) span -= 2 * M_PI;
    Vec2 mid = vec2_scale(vec2_add(from, to), 0.5);
    int steps = (int)ceil(fabs(span) / ARC_STEP);
    for (int i = 1; i < steps; i++) {
        double a = a0 + span * i / steps;
        Vec2 e = vec2((centre.x + cos(a)) * rx, (centre.y + sin(a)) * ry);
        append_to_path(p, vec2_add(mid, vec2(c * e.x - s * e.y, s * e.x + c * e.y)));
    }
    append_to_path(p, to);
}

static void command(Path *p, char letter, bool relative) {
    if (letter == 'L') {
        append_to_path(p, point(p, relative));
    } else if (letter == 'H') {
        double x = number(p);
        append_to_path(p, vec2(relative ? p->here.x + x : x, p->here.y));
    } else if (letter == 'V') {
        double y = number(p);
        append_to_path(p, vec2(p->here.x, relative ? p->here.y + y : y));
    } else if (letter == 'C') {
        Vec2 b = point(p, relative), c = point(p, relative);
        cubic(p, b, c, point(p, relative));
    } else if (letter == 'Q') {
        Vec2 a = p->here, b = point(p, relative), d = point(p, relative);
        Vec2 b1 = vec2((a.x + 2 * b.x) / 3, (a.y + 2 * b.y) / 3),
             b2 = vec2((d.x + 2 * b.x) / 3, (d.y + 2 * b.y) / 3);
        cubic(p, b1, b2, d);
    } else if (letter == 'A') {
        double rx = number(p), ry = number(p), turn = number(p) * M_PI / 180;
        bool large = flag(p), sweep = flag(p);
        arc(p, rx, ry, turn, large, sweep, point(p, relative));
    } else {
        p->failed = true;
    }
}

int sh3d_shape(const char *path, Vec2 *out, int max) {
    Path p = {.at = path, .out = out, .max = max < SH3D_MAX_SHAPE ? max : SH3D_MAX_SHAPE};
    char letter = 0;
    bool relative = false;
    for (skip(&p); *p.at && !p.failed; skip(&p)) {
        if (isalpha((unsigned char)*p.at)) {
            letter = (char)toupper((unsigned char)*p.at);
            relative = islower((unsigned char)*p.at++);
            if (letter == 'Z') {
                close_figure(&p);
                continue;
            }
            if (letter == 'M') {
                Vec2 to = point(&p, relative);
                close_figure(&p);
                p.start = to;
                append_to_path(&p, to);
                letter = 'L';
                continue;
            }
        } else if (!number_follows(&p) || letter == 'Z') {
            return 0;
        }
        // After a closed figure the next one starts where that one did.
        if (p.count == 0) append_to_path(&p, p.start);
        command(&p, letter, relative);
    }
    close_figure(&p);
    if (p.failed) return 0;
    memcpy(out, p.best, sizeof(Vec2) * (size_t)p.best_count);
    return p.best_count;
}
