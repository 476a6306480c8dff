// bezier_clip.c - rays against rational bicubic Bezier patches (Nishita, Sederberg & Kakimoto 1990). A ray is two planes;
// distances of control points to them make a patch in the plane, whose roots are hits. Distances to a line along v, and to
// one along u, bound where roots may lie in u and in v: what the convex hulls leave out is clipped, and a part that does
// not shrink is halved.
//
// Departures. It begins from the nearly flat pieces of bezier_patch.c that the ray's boxes leave. As soon as the tangents
// along u of a part lie in one cone and those along v in another, apart from it, the part has one root or none, and
// Newton's steps find it. Where a part folds, roots may be double: the place is found by Gauss-Newton's steps, on the
// two distances and the determinant of their derivatives together, which knows it to the last digits; the distances
// alone would only to half of them.
#include "visibility/bezier/bezier_clip.h"

#include "visibility/bezier/bezier_beam.h"
#include "visibility/bezier/bezier_part.h"

// A part that keeps more than this both ways is halved (Nishita, Sederberg & Kakimoto 1990).
#define SHRINKS 0.8
// A clip leaves this much: a narrower part is worse to compute with, and Newton's steps need none.
#define LEAST_LEFT 1e-3
// Of a piece: parts that fold and are no larger than this may be a double root.
#define MAY_TOUCH 1e-2
// A part whose distances are all less than that, of the slack, is a point: where a row of control points is one, all along it.
#define POINT 8
// How far beyond a part's border a root may lie, of the slack: neighbours then leave no crack.
#define AT_BORDER 0.25
// Distances of that are rounding alone, and no step makes them less.
#define ROUNDED 0.02
// A step this small, of a part, is the last: squared, it is less than rounding.
#define LAST_STEP 1e-7
enum {
    WAITING = 64,     // parts: each halving leaves one
    MOST_PARTS = 400  // of a piece: tangent rays take 50; one that stays in the surface would take any number
};
enum { MOST_STEPS = 8 };  // of Newton: from within a part with one root three or four do

// ---- roots

// Is there no root but the one at u, v, outside the part but no farther than half its size?
static bool is_alone(const BezierPart *part) {
    BezierPart wide = *part;
    bezier_part_cut(&wide, (double[]){-0.5, -0.5}, (double[]){1.5, 1.5});
    return bezier_part_has_one_root_at_most(&wide);
}

static double into_part(double s) { return s < 0 ? 0 : s > 1 ? 1 : s; }

static bool is_on_ray(const BezierBeam *beam, const BezierPlace *at) {
    return fmax(fabs(at->a), fabs(at->b)) <= AT_BORDER * beam->slack;
}

// Is the root at u, v no farther outside than rounding? Then it is moved to the border, and along it to where it is nearest,
// since a grazing ray's place on the surface is known far less well than its distance from it.
static bool is_at_border(const BezierBeam *beam, const BezierPart *part, double *u, double *v) {
    double from_u = into_part(*u), from_v = into_part(*v);
    bool out_u = from_u != *u, out_v = from_v != *v;
    BezierPlace at = bezier_part_place(part, from_u, from_v);
    double step_u = -(at.a * at.a_u + at.b * at.b_u) / (at.a_u * at.a_u + at.b_u * at.b_u);
    double step_v = -(at.a * at.a_v + at.b * at.b_v) / (at.a_v * at.a_v + at.b_v * at.b_v);
    *u = from_u;
    *v = from_v;
    if (is_on_ray(beam, &at)) return true;
    if (out_u) {
        *v = into_part(from_v + step_v);
        at = bezier_part_place(part, *u, *v);
        if (is_on_ray(beam, &at)) return true;
    }
    if (!out_v) return false;
    *u = into_part(from_u + step_u);
    *v = from_v;
    at = bezier_part_place(part, *u, *v);
    return is_on_ray(beam, &at);
}

typedef enum Search { FOUND, NONE, UNKNOWN } Search;

// Newton's steps from u, v to the one root there may be in the part.
static Search find_root(const BezierBeam *beam, const BezierPart *part, double *u, double *v) {
    for (int i = 0; i < MOST_STEPS; i++) {
        BezierPlace at = bezier_part_place(part, *u, *v);
        beam->work->steps++;
        double determinant = at.a_u * at.b_v - at.a_v * at.b_u;
        double du = (at.a_v * at.b - at.b_v * at.a) / determinant;
        double dv = (at.b_u * at.a - at.a_u * at.b) / determinant;
        *u += du;
        *v += dv;
        if (!(fabs(*u - 0.5) < 1 && fabs(*v - 0.5) < 1)) return UNKNOWN;
        bool rounded = fmax(fabs(at.a), fabs(at.b)) <= ROUNDED * beam->slack;
        if (fabs(du) + fabs(dv) > LAST_STEP && !rounded) continue;
        if (*u >= 0 && *u <= 1 && *v >= 0 && *v <= 1) return FOUND;
        if (is_at_border(beam, part, u, v)) return FOUND;
        return is_alone(part) ? NONE : UNKNOWN;
    }
    return UNKNOWN;
}

// ---- folds

// A Gauss-Newton step to where both distances and the determinant of their derivatives are 0.
static bool fold_step(const BezierPart *part, double *u, double *v, double *step) {
    BezierPlace p = bezier_part_place(part, *u, *v);
    BezierBends c = bezier_part_bends(part, *u, *v);
    double scale = sqrt(p.a_u * p.a_u + p.a_v * p.a_v + p.b_u * p.b_u + p.b_v * p.b_v);
    if (!(scale > 0)) return false;
    double r[3] = {p.a, p.b, (p.a_u * p.b_v - p.a_v * p.b_u) / scale};
    double ju[3] = {p.a_u, p.b_u,
                    (c.a_uu * p.b_v + p.a_u * c.b_uv - c.a_uv * p.b_u - p.a_v * c.b_uu) / scale};
    double jv[3] = {p.a_v, p.b_v,
                    (c.a_uv * p.b_v + p.a_u * c.b_vv - c.a_vv * p.b_u - p.a_v * c.b_uv) / scale};
    double uu = 0, uv = 0, vv = 0, gu = 0, gv = 0;
    for (int i = 0; i < 3; i++) {
        uu += ju[i] * ju[i], uv += ju[i] * jv[i], vv += jv[i] * jv[i];
        gu += ju[i] * r[i], gv += jv[i] * r[i];
    }
    double determinant = uu * vv - uv * uv, du = (uv * gv - vv * gu) / determinant;
    double dv = (uv * gu - uu * gv) / determinant;
    *u += du;
    *v += dv;
    *step = fabs(du) + fabs(dv);
    return fabs(*u - 0.5) < 1.5 && fabs(*v - 0.5) < 1.5;
}

static bool find_double_root(const BezierBeam *beam, const BezierPart *part, double *u, double *v) {
    *u = *v = 0.5;
    double step = 1;
    for (int i = 0; i < MOST_STEPS && step > 1e-9; i++) {
        beam->work->steps++;
        if (!fold_step(part, u, v, &step)) return false;
    }
    *u = fmin(fmax(*u, 0), 1);
    *v = fmin(fmax(*v, 0), 1);
    BezierPlace at = bezier_part_place(part, *u, *v);
    return fabs(at.a) <= 4 * beam->slack && fabs(at.b) <= 4 * beam->slack;
}

// ---- parts

static void add_hit(const BezierBeam *beam, const PatchPiece *piece, const BezierPart *part, double u,
                    double v) {
    bezier_beam_hit(beam, piece, part->u + u * part->width_u, part->v + v * part->width_v);
}

static void widen_part(double *from, double *to) {
    double more = (LEAST_LEFT - (*to - *from)) / 2;
    if (!(more > 0)) return;
    *from = fmax(0, fmin(*from - more, 1 - LEAST_LEFT));
    *to = *from + LEAST_LEFT;
}

// The roots of a part that are told without clipping it, given where its hulls leave them.
static Search search_roots(const BezierBeam *beam, const BezierPart *part, const double from[2],
                           const double to[2], double *u, double *v) {
    *u = (from[0] + to[0]) / 2;
    *v = (from[1] + to[1]) / 2;
    if (bezier_part_has_one_root_at_most(part)) return find_root(beam, part, u, v);
    bool small = fmax(part->width_u, part->width_v) < MAY_TOUCH;
    return small && find_double_root(beam, part, u, v) ? FOUND : UNKNOWN;
}

// Clips a part until it is empty, or its hits are known, or it must be halved. True: halve it.
static bool clip_patch_part(const BezierBeam *beam, const PatchPiece *piece, BezierPart *part) {
    for (;;) {
        double from[2], to[2], u, v;
        beam->work->clips += 2;
        if (!bezier_part_clip(part, beam->slack, from, to)) return false;
        if (bezier_part_is_zero(part, POINT * beam->slack)) {
            add_hit(beam, piece, part, 0.5, 0.5);
            return false;
        }
        Search found = search_roots(beam, part, from, to, &u, &v);
        if (found == FOUND) add_hit(beam, piece, part, u, v);
        if (found != UNKNOWN) return false;
        if (to[0] - from[0] > SHRINKS && to[1] - from[1] > SHRINKS) return true;
        for (int k = 0; k < 2; k++) widen_part(&from[k], &to[k]);
        bezier_part_cut(part, from, to);
    }
}

static bool misses(const Four row[4], double slack) {
    return four_least_of(four_least_row(row)) > slack || four_most_of(four_most_row(row)) < -slack;
}

static void piece_hits(const BezierBeam *beam, const PatchPiece *piece) {
    Four f[4], g[4];
    bezier_beam_project(beam, &piece->net, 0, f);
    if (misses(f, beam->slack)) return;
    bezier_beam_project(beam, &piece->net, 1, g);
    if (misses(g, beam->slack)) return;
    BezierPart waiting[WAITING];
    waiting[0].u = waiting[0].v = 0;
    waiting[0].width_u = waiting[0].width_v = 1;
    bezier_part_measure(&waiting[0], f, g, true);
    int count = 1;
    for (int parts = 0; count > 0; parts++) {
        if (parts == MOST_PARTS || count + 2 > WAITING) {
            beam->work->undecided++;
            return;
        }
        BezierPart part = waiting[--count];
        if (!clip_patch_part(beam, piece, &part)) continue;
        beam->work->splits++;
        waiting[count] = part;
        bezier_part_halve(&waiting[count], &waiting[count + 1]);
        count += 2;
    }
}

void bezier_hits(const BezierPatch *patch, const Ray *ray, HitList *list, CurvedWork *work) {
    BezierBeam beam;
    if (bezier_beam(patch, ray, list, work, &beam)) bezier_beam_pieces(&beam, piece_hits);
}
