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
#include "visibility/rays/bezier_clip.h"

#include <string.h>

// A part that keeps more than this both ways is halved (Nishita, Sederberg & Kakimoto 1990).
#define SHRINKS 0.8
// A clip leaves this much: a narrower part is worse to compute with, and Newton's steps need none.
#define LEAST_LEFT 1e-3
// Distances that count as 0, of the patch's size: rounding of the ray, of its origin ten sizes away, and of the net.
#define ROUNDING 4e-14
// Of a piece: parts that fold and are no larger than this may be a double root; those that are no larger than the second
// are one.
#define MAY_TOUCH 1e-2
#define NARROWEST 1e-9
// Hits with t no more than this apart, of the size, and the same normal, are one that was found in two parts.
#define SAME_HIT 1e-11
#define SAME_NORMAL 1e-8  // 1 - cosine
// Tangents whose cross product is less than this of their lengths make no frame to measure in.
#define ASKEW 0.1
enum {
    WAITING = 64,     // parts: each halving leaves one
    MOST_PARTS = 400  // of a piece: tangent rays take 50; a ray within a flat piece would take any number
};
enum { MOST_STEPS = 8 };  // of Newton: from within a part with one root three or four do

// A ray about the patch's centre, and two planes through it.
typedef struct Beam {
    const BezierPatch *patch;
    Vec3 o, d;     // o is nearest to the centre
    Vec3 n[2];     // of the planes
    double e[2];   // dot(n, o)
    double start;  // t of o
    double slack;
    HitList *list;
    CurvedWork *work;
} Beam;

// Part of a piece, in the plane across the ray.
typedef struct Part {
    Lane4 a[4];  // distances to a line along v; rows of v, lanes along u
    Lane4 b[4];  // to a line along u; rows of u, lanes along v
    double u, v, width_u, width_v;
} Part;

// ---- distances

static void project(const Beam *beam, const PatchNet *net, int plane, Lane4 out[4]) {
    Vec3 n = beam->n[plane];
    for (int k = 0; k < 4; k++)
        out[k] = (n.x * net->x[k] + n.y * net->y[k]) + (n.z * net->z[k] - beam->e[plane] * net->w[k]);
}

static Lane4 least_row(const Lane4 row[4]) {
    return lane4_least(lane4_least(row[0], row[1]), lane4_least(row[2], row[3]));
}
static Lane4 most_row(const Lane4 row[4]) {
    return lane4_most(lane4_most(row[0], row[1]), lane4_most(row[2], row[3]));
}

static bool misses(const Lane4 row[4], double slack) {
    return lane4_least_of(least_row(row)) > slack || lane4_most_of(most_row(row)) < -slack;
}

// The mean tangents of a net in the plane, from its corners; both rows of v, lanes along u.
static void mean_tangents(const Lane4 f[4], const Lane4 g[4], Vec2 *along_u, Vec2 *along_v) {
    *along_u = vec2(f[0][3] - f[0][0] + f[3][3] - f[3][0], g[0][3] - g[0][0] + g[3][3] - g[3][0]);
    *along_v = vec2(f[3][0] - f[0][0] + f[3][3] - f[0][3], g[3][0] - g[0][0] + g[3][3] - g[0][3]);
}

static Vec2 unit(Vec2 a, Vec2 instead) {
    double length = vec2_length(a);
    return length > 0 ? vec2_scale(a, 1 / length) : instead;
}

// Lines along the mean tangents; where these are nearly one, the second line is across the first: only so is a part
// clipped along both.
static void choose_lines(const Lane4 f[4], const Lane4 g[4], bool for_clips, Vec2 *along_u, Vec2 *along_v) {
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

// From two distances f and g, rows of v and lanes along u.
static void measure(Part *part, const Lane4 f[4], const Lane4 g[4], bool for_clips) {
    Vec2 u, v;
    choose_lines(f, g, for_clips, &u, &v);
    Lane4 a[4], b[4];
    for (int k = 0; k < 4; k++) {
        a[k] = f[k] * v.y - g[k] * v.x;
        b[k] = u.x * g[k] - u.y * f[k];
    }
    lane4_transpose(b);
    memcpy(part->a, a, sizeof a);
    memcpy(part->b, b, sizeof b);
}

static void measure_again(Part *part, bool for_clips) {
    Lane4 f[4], g[4];
    memcpy(f, part->a, sizeof f);
    memcpy(g, part->b, sizeof g);
    lane4_transpose(g);
    measure(part, f, g, for_clips);
}

// ---- clips

// Where the hull of (lane / 3, low .. high) comes down to 0 from lane 0 on, in lanes; low[0] > 0.
static double comes_down(const double low[4]) {
    double first = 3;
    for (int j = 1; j < 4; j++) {
        if (!(low[j] <= 0)) continue;
        for (int i = 0; i < j; i++)
            if (low[i] > 0) first = fmin(first, i + (j - i) * (low[i] / (low[i] - low[j])));
    }
    return first;
}

// The lanes, as 0 .. 1, outside which no distance is within slack of 0. False: none is.
static bool clip(const Lane4 row[4], double slack, double *from, double *to) {
    Lane4 low = least_row(row) - lane4_of(slack), high = -most_row(row) - lane4_of(slack);
    unsigned above = lane4_mask(low > lane4_of(0)), below = lane4_mask(high > lane4_of(0));
    if (above == 15 || below == 15) return false;
    *from = 0;
    *to = 1;
    if ((above | below) & 1) {
        Lane4 a = above & 1 ? low : high;
        *from = comes_down((double[]){a[0], a[1], a[2], a[3]}) / 3;
    }
    if ((above | below) & 8) {
        Lane4 a = above & 8 ? low : high;
        *to = 1 - comes_down((double[]){a[3], a[2], a[1], a[0]}) / 3;
    }
    return true;
}

static void widen(double *from, double *to) {
    double more = (LEAST_LEFT - (*to - *from)) / 2;
    if (!(more > 0)) return;
    *from = fmax(0, fmin(*from - more, 1 - LEAST_LEFT));
    *to = *from + LEAST_LEFT;
}

static void cut_u(Part *part, double from, double to) {
    BezierCut cut = bezier_cut(from, to);
    bezier_cut_lanes(part->a, &cut);
    bezier_cut_rows(part->b, &cut);
    part->u += from * part->width_u;
    part->width_u *= to - from;
}

static void cut_v(Part *part, double from, double to) {
    BezierCut cut = bezier_cut(from, to);
    bezier_cut_rows(part->a, &cut);
    bezier_cut_lanes(part->b, &cut);
    part->v += from * part->width_v;
    part->width_v *= to - from;
}

// ---- one root or none

// The least difference of neighbouring lanes, which is along the distance's own parameter; the largest of rows.
static void slopes(const Lane4 row[4], double *least, double *most_across) {
    Lane4 along[4], across = lane4_of(0);
    for (int k = 0; k < 4; k++)
        along[k] = __builtin_shufflevector(row[k], row[k], 1, 2, 3, 3) -
                   __builtin_shufflevector(row[k], row[k], 0, 1, 2, 2);
    for (int k = 0; k < 3; k++) across = lane4_most(across, lane4_abs(row[k + 1] - row[k]));
    *least = lane4_least_of(least_row(along));
    *most_across = lane4_most_of(across);
}

static bool cones_are_apart(const Part *part) {
    double a_u, a_v, b_v, b_u;
    slopes(part->a, &a_u, &a_v);
    slopes(part->b, &b_v, &b_u);
    return a_u > 0 && b_v > 0 && a_u * b_v > a_v * b_u;
}

static bool has_one_root_at_most(const Part *part) {
    if (cones_are_apart(part)) return true;
    Part again = *part;
    measure_again(&again, false);
    return cones_are_apart(&again);
}

static Lane4 over_rows(const Lane4 row[4], Lane4 basis) {
    return (basis[0] * row[0] + basis[1] * row[1]) + (basis[2] * row[2] + basis[3] * row[3]);
}

// Both distances and their derivatives.
typedef struct Place {
    double a, a_u, a_v, b, b_u, b_v;
} Place;

static Place place_at(const Part *part, double u, double v) {
    Lane4 bu = bezier_basis(u), su = bezier_slopes(u), bv = bezier_basis(v), sv = bezier_slopes(v);
    Lane4 a = over_rows(part->a, bv), b = over_rows(part->b, bu);
    return (Place){lane4_sum(a * bu),
                   lane4_sum(a * su),
                   lane4_sum(over_rows(part->a, sv) * bu),
                   lane4_sum(b * bv),
                   lane4_sum(over_rows(part->b, su) * bv),
                   lane4_sum(b * sv)};
}

// Newton's steps to the one root there may be in the part. False: it is not there, or was not found.
static bool find_root(const Beam *beam, const Part *part, double *u, double *v) {
    *u = *v = 0.5;
    for (int i = 0; i < MOST_STEPS; i++) {
        Place at = place_at(part, *u, *v);
        beam->work->steps++;
        double determinant = at.a_u * at.b_v - at.a_v * at.b_u;
        double du = (at.a_v * at.b - at.b_v * at.a) / determinant;
        double dv = (at.b_u * at.a - at.a_u * at.b) / determinant;
        *u += du;
        *v += dv;
        if (!(fabs(*u - 0.5) < 1.5 && fabs(*v - 0.5) < 1.5)) return false;
        if (fabs(du) + fabs(dv) > 1e-7) continue;  // squared, it is less than rounding
        double in_u = fmin(fmax(*u, 0), 1), in_v = fmin(fmax(*v, 0), 1);
        if (in_u == *u && in_v == *v) return true;
        at = place_at(part, in_u, in_v);
        *u = in_u;
        *v = in_v;
        return fabs(at.a) <= 2 * beam->slack && fabs(at.b) <= 2 * beam->slack;
    }
    return false;
}

// ---- folds

typedef struct Bends {
    double a_uu, a_uv, a_vv, b_uu, b_uv, b_vv;
} Bends;

static Bends bends_at(const Part *part, double u, double v) {
    Lane4 bu = bezier_basis(u), su = bezier_slopes(u), cu = bezier_bends(u);
    Lane4 bv = bezier_basis(v), sv = bezier_slopes(v), cv = bezier_bends(v);
    return (Bends){lane4_sum(over_rows(part->a, bv) * cu), lane4_sum(over_rows(part->a, sv) * su),
                   lane4_sum(over_rows(part->a, cv) * bu), lane4_sum(over_rows(part->b, cu) * bv),
                   lane4_sum(over_rows(part->b, su) * sv), lane4_sum(over_rows(part->b, bu) * cv)};
}

// A Gauss-Newton step to where both distances and the determinant of their derivatives are 0.
static bool fold_step(const Part *part, double *u, double *v, double *step) {
    Place p = place_at(part, *u, *v);
    Bends c = bends_at(part, *u, *v);
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

static bool find_double_root(const Beam *beam, const Part *part, double *u, double *v) {
    *u = *v = 0.5;
    double step = 1;
    for (int i = 0; i < MOST_STEPS && step > 1e-9; i++) {
        beam->work->steps++;
        if (!fold_step(part, u, v, &step)) return false;
    }
    *u = fmin(fmax(*u, 0), 1);
    *v = fmin(fmax(*v, 0), 1);
    Place at = place_at(part, *u, *v);
    return fabs(at.a) <= 4 * beam->slack && fabs(at.b) <= 4 * beam->slack;
}

// ---- hits

// Where a patch has no normal - a row of its control points is one point - that from beside it, towards the piece's middle.
static Vec3 normal_at(const PatchNet *net, double u, double v, const PatchPoint *at) {
    Vec3 n = vec3_cross(at->du, at->dv);
    double lengths = vec3_length(at->du) + vec3_length(at->dv);
    for (double beside = 1e-6; vec3_length(n) <= 1e-9 * lengths * lengths && beside < 1; beside *= 100) {
        PatchPoint near = bezier_patch_point(net, u + beside * (0.5 - u), v + beside * (0.5 - v));
        n = vec3_cross(vec3_normalize(near.du), vec3_normalize(near.dv));
        lengths = 1;
    }
    return vec3_normalize(n);
}

static bool is_known(const Beam *beam, const RayHit *hit) {
    const HitList *list = beam->list;
    for (int i = 0; i < list->count && i < list->max; i++)
        if (fabs(list->hits[i].t - hit->t) <= SAME_HIT * beam->patch->size &&
            1 - fabs(vec3_dot(list->hits[i].normal, hit->normal)) < SAME_NORMAL)
            return true;
    return false;
}

// At u, v of the part.
static void add_hit(const Beam *beam, const PatchPiece *piece, const Part *part, double u, double v) {
    u = part->u + u * part->width_u;
    v = part->v + v * part->width_v;
    PatchPoint at = bezier_patch_point(&piece->net, u, v);
    RayHit hit = {.t = beam->start + vec3_dot(beam->d, vec3_sub(at.p, beam->o)),
                  .u = piece->u + u * piece->width_u,
                  .v = piece->v + v * piece->width_v};
    if (!hit_list_wants(beam->list, hit.t)) return;
    if (piece->trimmed && !trim_keeps(beam->patch->trim, vec2(hit.u, hit.v), beam->work)) return;
    hit.normal = normal_at(&piece->net, u, v, &at);
    if (!is_known(beam, &hit)) hit_list_add(beam->list, hit);
}

// ---- parts

static bool is_zero(const Part *part, double slack) {
    return !(lane4_most_of(most_row(part->a)) > slack || lane4_least_of(least_row(part->a)) < -slack ||
             lane4_most_of(most_row(part->b)) > slack || lane4_least_of(least_row(part->b)) < -slack);
}

// Clips a part until it is empty, or its hits are known, or it must be halved. True: halve it.
static bool settle(const Beam *beam, const PatchPiece *piece, Part *part) {
    for (;;) {
        double from[2], to[2], u, v;
        if (!clip(part->a, beam->slack, &from[0], &to[0])) return false;
        if (!clip(part->b, beam->slack, &from[1], &to[1])) return false;
        beam->work->clips += 2;
        bool shrinks = to[0] - from[0] <= SHRINKS || to[1] - from[1] <= SHRINKS;
        widen(&from[0], &to[0]);
        widen(&from[1], &to[1]);
        cut_u(part, from[0], to[0]);
        cut_v(part, from[1], to[1]);
        if (is_zero(part, beam->slack) || fmax(part->width_u, part->width_v) < NARROWEST) {
            add_hit(beam, piece, part, 0.5, 0.5);
            return false;
        }
        bool one = has_one_root_at_most(part);
        if (one ? find_root(beam, part, &u, &v)
                : fmax(part->width_u, part->width_v) < MAY_TOUCH && find_double_root(beam, part, &u, &v)) {
            add_hit(beam, piece, part, u, v);
            return false;
        }
        if (!shrinks) return true;
    }
}

// Across the longer of its mean tangents.
static void halve(Part *first, Part *second) {
    Lane4 g[4];
    Vec2 u, v;
    memcpy(g, first->b, sizeof g);
    lane4_transpose(g);
    mean_tangents(first->a, g, &u, &v);
    measure_again(first, true);
    *second = *first;
    if (vec2_dot(u, u) > vec2_dot(v, v)) {
        cut_u(first, 0, 0.5);
        cut_u(second, 0.5, 1);
    } else {
        cut_v(first, 0, 0.5);
        cut_v(second, 0.5, 1);
    }
}

static void piece_hits(const Beam *beam, const PatchPiece *piece) {
    Lane4 f[4], g[4];
    project(beam, &piece->net, 0, f);
    if (misses(f, beam->slack)) return;
    project(beam, &piece->net, 1, g);
    if (misses(g, beam->slack)) return;
    Part waiting[WAITING] = {{.width_u = 1, .width_v = 1}};
    measure(&waiting[0], f, g, true);
    int count = 1;
    for (int parts = 0; count > 0; parts++) {
        if (parts == MOST_PARTS || count + 2 > WAITING) {
            beam->work->undecided++;
            return;
        }
        Part part = waiting[--count];
        if (!settle(beam, piece, &part)) continue;
        beam->work->splits++;
        waiting[count] = part;
        halve(&waiting[count], &waiting[count + 1]);
        count += 2;
    }
}

// ---- the tree

// Axes across a unit vector, without a branch (Duff et al. 2017).
static void axes_across(Vec3 d, Vec3 n[2]) {
    double sign = copysign(1, d.z), a = -1 / (sign + d.z), b = d.x * d.y * a;
    n[0] = vec3(1 + sign * d.x * d.x * a, sign * b, -sign * d.x);
    n[1] = vec3(b, sign + d.y * d.y * a, -d.y);
}

// No component is 0, so that no slab is 0 / 0.
static double inverse(double d) { return 1 / (fabs(d) > 1e-300 ? d : copysign(1e-300, d)); }

typedef struct Entry {
    int child;
    double t;  // from the beam's o
} Entry;

// The children that the beam meets, the nearest last. Returns how many.
static int children_met(const Beam *beam, const Vec3 *inverse_d, const PatchNode *node, Entry out[4]) {
    const double o[3] = {beam->o.x, beam->o.y, beam->o.z}, d[3] = {inverse_d->x, inverse_d->y, inverse_d->z};
    Lane4 in = lane4_of(beam->list->near - beam->start), leave = lane4_of(beam->list->far - beam->start);
    for (int k = 0; k < 3; k++) {
        Lane4 a = (node->low[k] - lane4_of(o[k])) * lane4_of(d[k]);
        Lane4 b = (node->high[k] - lane4_of(o[k])) * lane4_of(d[k]);
        in = lane4_most(lane4_least(a, b), in);
        leave = lane4_least(lane4_most(a, b), leave);
    }
    int count = 0;
    for (unsigned met = lane4_mask(in <= leave) & ((1u << node->count) - 1); met; met &= met - 1) {
        int i = __builtin_ctz(met), k = count++;
        for (; k > 0 && out[k - 1].t < in[i]; k--) out[k] = out[k - 1];
        out[k] = (Entry){node->child[i], in[i]};
    }
    return count;
}

void bezier_hits(const BezierPatch *patch, const Ray *ray, HitList *list, CurvedWork *work) {
    Beam beam = {.patch = patch, .d = ray->direction, .list = list, .work = work};
    Vec3 from = vec3_sub(ray->origin, patch->centre);
    beam.start = -vec3_dot(from, ray->direction);
    beam.o = vec3_add(from, vec3_scale(ray->direction, beam.start));
    if (4 * vec3_dot(beam.o, beam.o) > 1.001 * patch->size * patch->size) return;  // beside its sphere
    beam.slack = ROUNDING * patch->size;
    axes_across(beam.d, beam.n);
    for (int k = 0; k < 2; k++) beam.e[k] = vec3_dot(beam.n[k], beam.o);
    Vec3 inverse_d = vec3(inverse(beam.d.x), inverse(beam.d.y), inverse(beam.d.z));
    Entry waiting[64] = {{0, -INFINITY}};  // three are left at each of the tree's levels
    for (int count = 1; count > 0;) {
        Entry entry = waiting[--count];
        if (entry.t + beam.start >= list->far) continue;
        if (entry.child < 0)
            piece_hits(&beam, &patch->pieces[~entry.child]);
        else
            count += children_met(&beam, &inverse_d, &patch->nodes[entry.child], waiting + count);
    }
}
