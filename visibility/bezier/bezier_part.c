// bezier_part.c - parts of a patch along a ray: clipped by convex hulls (Nishita, Sederberg & Kakimoto 1990, section 3), cut,
// halved, and told to have one root at most.
#include "visibility/bezier/bezier_part.h"

#include <string.h>

// Tangents whose cross product is less than this of their lengths make no frame to measure in.
#define ASKEW 0.2

// ---- lines

// The mean tangents of a net in the plane, from its corners; both rows of v, lanes along u.
static void mean_tangents(const Four f[4], const Four g[4], Vec2 *along_u, Vec2 *along_v) {
    *along_u = vec2(f[0][3] - f[0][0] + f[3][3] - f[3][0], g[0][3] - g[0][0] + g[3][3] - g[3][0]);
    *along_v = vec2(f[3][0] - f[0][0] + f[3][3] - f[0][3], g[3][0] - g[0][0] + g[3][3] - g[0][3]);
}

static Vec2 unit(Vec2 a, Vec2 instead) {
    double length = vec2_length(a);
    return length > 0 ? vec2_scale(a, 1 / length) : instead;
}

// Lines along the mean tangents; where these are nearly one, the second line is across the first: only so is a part
// clipped along both.
static void choose_lines(const Four f[4], const Four g[4], bool for_clips, Vec2 *along_u, Vec2 *along_v) {
    Vec2 u, v;
    mean_tangents(f, g, &u, &v);
    double long_u = vec2_length(u), long_v = vec2_length(v);
    bool u_leads = long_u >= long_v;
    u = unit(u, unit(vec2(v.y, -v.x), vec2(1, 0)));
    v = unit(v, vec2(-u.y, u.x));
    if (for_clips && fabs(vec2_cross(u, v)) < ASKEW) {
        if (u_leads)
            v = vec2(-u.y, u.x);
        else
            u = vec2(v.y, -v.x);
    }
    double sign = vec2_cross(u, v) < 0 ? -1 : 1;  // so that distances grow with u and v
    *along_u = vec2_scale(u, sign);
    *along_v = vec2_scale(v, sign);
}

void bezier_part_measure(BezierPart *part, const Four f[4], const Four g[4], bool for_clips) {
    Vec2 u, v;
    choose_lines(f, g, for_clips, &u, &v);
    part->along_u = u;
    part->along_v = v;
    for (int k = 0; k < 4; k++) {
        part->a[k] = f[k] * v.y - g[k] * v.x;
        part->b[k] = u.x * g[k] - u.y * f[k];
    }
    four_transpose(part->b);
}

// The coordinates again.
static void coordinates(const BezierPart *part, Four f[4], Four g[4]) {
    Vec2 u = part->along_u, v = part->along_v;
    double scale = 1 / vec2_cross(u, v);
    Four b[4];
    memcpy(b, part->b, sizeof b);
    four_transpose(b);
    for (int k = 0; k < 4; k++) {
        f[k] = (part->a[k] * u.x + b[k] * v.x) * scale;
        g[k] = (part->a[k] * u.y + b[k] * v.y) * scale;
    }
}

// ---- clips

// Where the hull of (lane / 3, low .. high) comes down to 0 from lane 0 on, in lanes; low[0] > 0.
static double comes_down(const double low[4]) {
    double first = 3;
    for (int j = 1; j < 4; j++) {
        if (!(low[j] <= 0)) continue;
        for (int i = 0; i < j; i++)
            if (low[i] > 0) {
                double at = i + (j - i) * (low[i] / (low[i] - low[j]));
                first = at < first ? at : first;
            }
    }
    return first;
}

// The lanes, as 0 .. 1, outside which no distance is within slack of 0. False: none is.
static bool clip_lanes(const Four row[4], double slack, double *from, double *to) {
    Four low = four_least_row(row) - four_of(slack), high = -four_most_row(row) - four_of(slack);
    unsigned above = four_lanes(low > four_of(0)), below = four_lanes(high > four_of(0));
    if (above == 15 || below == 15) return false;
    *from = 0;
    *to = 1;
    if ((above | below) & 1) {
        Four a = above & 1 ? low : high;
        *from = comes_down((double[]){a[0], a[1], a[2], a[3]}) / 3;
    }
    if ((above | below) & 8) {
        Four a = above & 8 ? low : high;
        *to = 1 - comes_down((double[]){a[3], a[2], a[1], a[0]}) / 3;
    }
    return true;
}

bool bezier_part_clip(const BezierPart *part, double slack, double from[2], double to[2]) {
    return clip_lanes(part->a, slack, &from[0], &to[0]) && clip_lanes(part->b, slack, &from[1], &to[1]);
}

// Along one parameter, which runs over the lanes of one of the distances and the rows of the other.
static void cut_lanes(Four lanes[4], Four rows[4], double *at, double *width, double from, double to) {
    BezierCut piece = bezier_cut(from, to);
    bezier_cut_lanes(lanes, &piece);
    bezier_cut_rows(rows, &piece);
    *at += from * *width;
    *width *= to - from;
}

static void cut_u(BezierPart *part, double from, double to) {
    cut_lanes(part->a, part->b, &part->u, &part->width_u, from, to);
}

static void cut_v(BezierPart *part, double from, double to) {
    cut_lanes(part->b, part->a, &part->v, &part->width_v, from, to);
}

void bezier_part_cut(BezierPart *part, const double from[2], const double to[2]) {
    cut_u(part, from[0], to[0]);
    cut_v(part, from[1], to[1]);
}

void bezier_part_halve(BezierPart *first, BezierPart *second) {
    Four f[4], g[4];
    Vec2 u, v;
    coordinates(first, f, g);
    mean_tangents(f, g, &u, &v);
    bezier_part_measure(first, f, g, true);
    *second = *first;
    if (vec2_dot(u, u) > vec2_dot(v, v)) {
        cut_u(first, 0, 0.5);
        cut_u(second, 0.5, 1);
    } else {
        cut_v(first, 0, 0.5);
        cut_v(second, 0.5, 1);
    }
}

bool bezier_part_is_zero(const BezierPart *part, double slack) {
    return !(four_most_of(four_most_row(part->a)) > slack ||
             four_least_of(four_least_row(part->a)) < -slack ||
             four_most_of(four_most_row(part->b)) > slack || four_least_of(four_least_row(part->b)) < -slack);
}

// ---- one root or none

// The least difference of neighbouring lanes, which is along the distance's own parameter; the largest of rows.
static void slopes(const Four row[4], double *least, double *most_across) {
    Four along[4], across = four_of(0);
    for (int k = 0; k < 4; k++)
        along[k] = __builtin_shufflevector(row[k], row[k], 1, 2, 3, 3) -
                   __builtin_shufflevector(row[k], row[k], 0, 1, 2, 2);
    for (int k = 0; k < 3; k++) across = four_most(across, four_abs(row[k + 1] - row[k]));
    *least = four_least_of(four_least_row(along));
    *most_across = four_most_of(across);
}

static bool cones_are_apart(const BezierPart *part) {
    double a_u, a_v, b_v, b_u;
    slopes(part->a, &a_u, &a_v);
    slopes(part->b, &b_v, &b_u);
    return a_u > 0 && b_v > 0 && a_u * b_v > a_v * b_u;
}

bool bezier_part_has_one_root_at_most(const BezierPart *part) {
    if (cones_are_apart(part)) return true;
    BezierPart again;
    Four f[4], g[4];
    coordinates(part, f, g);
    bezier_part_measure(&again, f, g, false);
    return cones_are_apart(&again);
}

// ---- places

BezierPlace bezier_part_place(const BezierPart *part, double u, double v) {
    Four bu = bezier_basis(u), su = bezier_slopes(u), bv = bezier_basis(v), sv = bezier_slopes(v);
    Four a = bezier_over_rows(part->a, bv), b = bezier_over_rows(part->b, bu);
    return (BezierPlace){four_sum(a * bu),
                         four_sum(a * su),
                         four_sum(bezier_over_rows(part->a, sv) * bu),
                         four_sum(b * bv),
                         four_sum(bezier_over_rows(part->b, su) * bv),
                         four_sum(b * sv)};
}

BezierBends bezier_part_bends(const BezierPart *part, double u, double v) {
    Four bu = bezier_basis(u), su = bezier_slopes(u), cu = bezier_bends(u);
    Four bv = bezier_basis(v), sv = bezier_slopes(v), cv = bezier_bends(v);
    return (BezierBends){
        four_sum(bezier_over_rows(part->a, bv) * cu), four_sum(bezier_over_rows(part->a, sv) * su),
        four_sum(bezier_over_rows(part->a, cv) * bu), four_sum(bezier_over_rows(part->b, cu) * bv),
        four_sum(bezier_over_rows(part->b, su) * sv), four_sum(bezier_over_rows(part->b, bu) * cv)};
}
