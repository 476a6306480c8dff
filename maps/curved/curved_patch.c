// curved_patch.c - rational bicubic patches by Bernstein polynomials on homogeneous controls (w x, w y, w z, w).
#include "maps/curved/curved_patch.h"

typedef struct Homogeneous {
    Vec3 x;  // times the weight
    double w;
} Homogeneous;

// Below this share of the others a derivative counts as zero: far above the rounding of its sum.
static const double GONE = 1e-9;

static void add_weighted_control(Homogeneous *sum, double b, const CurvedControl *c) {
    double w = b * c->weight;
    sum->x = vec3_add(sum->x, vec3_scale(c->point, w));
    sum->w += w;
}

static void bernstein(double t, double b[4]) {
    double s = 1 - t;
    b[0] = s * s * s;
    b[1] = 3 * s * s * t;
    b[2] = 3 * s * t * t;
    b[3] = t * t * t;
}

static void bernstein_slope(double t, double d[4]) {
    double s = 1 - t;
    d[0] = -3 * s * s;
    d[1] = 3 * s * (s - 2 * t);
    d[2] = 3 * t * (2 * s - t);
    d[3] = 3 * t * t;
}

static Homogeneous sum_of(const CurvedControl control[PATCH_CONTROLS], const double bu[4],
                          const double bv[4]) {
    Homogeneous sum = {{0, 0, 0}, 0};
    for (int j = 0; j < 4; j++)
        for (int i = 0; i < 4; i++) add_weighted_control(&sum, bu[i] * bv[j], &control[4 * j + i]);
    return sum;
}

Vec3 curved_patch_point(const CurvedControl control[PATCH_CONTROLS], double u, double v) {
    if ((u == 0 || u == 1) && (v == 0 || v == 1)) return control[(v == 1 ? 12 : 0) + (u == 1 ? 3 : 0)].point;
    double bu[4], bv[4];
    bernstein(u, bu);
    bernstein(v, bv);
    Homogeneous sum = sum_of(control, bu, bv);
    return vec3_scale(sum.x, 1 / sum.w);
}

// Where one derivative is zero all along a border, it grows with the other parameter as `duv` says.
static Vec3 normal_of(Vec3 du, Vec3 dv, Vec3 duv, double u, double v) {
    double a = vec3_length(du), b = vec3_length(dv), c = vec3_length(duv), gone = GONE * fmax(a, fmax(b, c));
    if (a <= gone) du = vec3_scale(duv, v < 0.5 ? 1 : -1);
    if (b <= gone) dv = vec3_scale(duv, u < 0.5 ? 1 : -1);
    return vec3_normalize(vec3_cross(du, dv));
}

PatchPoint curved_patch_at(const CurvedControl control[PATCH_CONTROLS], double u, double v) {
    double bu[4], bv[4], du[4], dv[4];
    bernstein(u, bu);
    bernstein(v, bv);
    bernstein_slope(u, du);
    bernstein_slope(v, dv);
    Homogeneous p = sum_of(control, bu, bv), pu = sum_of(control, du, bv), pv = sum_of(control, bu, dv),
                puv = sum_of(control, du, dv);
    PatchPoint at = {.point = vec3_scale(p.x, 1 / p.w)};
    at.du = vec3_scale(vec3_sub(pu.x, vec3_scale(at.point, pu.w)), 1 / p.w);
    at.dv = vec3_scale(vec3_sub(pv.x, vec3_scale(at.point, pv.w)), 1 / p.w);
    Vec3 along =
        vec3_add(vec3_scale(at.dv, pu.w), vec3_add(vec3_scale(at.du, pv.w), vec3_scale(at.point, puv.w)));
    Vec3 duv = vec3_scale(vec3_sub(puv.x, along), 1 / p.w);
    at.normal = normal_of(at.du, at.dv, duv, u, v);
    return at;
}

void curved_patch_border(const CurvedControl control[PATCH_CONTROLS], int border, CurvedControl out[4]) {
    static const int FIRST[4] = {0, 3, 12, 0}, STEP[4] = {1, 4, 1, 4};
    for (int i = 0; i < 4; i++) out[i] = control[FIRST[border] + i * STEP[border]];
}

// Whichever way round the curve is given, it is summed from the same end.
static bool begins_behind(const CurvedControl c[4]) {
    for (int i = 0; i < 2; i++) {
        Vec3 a = c[i].point, b = c[3 - i].point;
        if (a.x != b.x) return a.x > b.x;
        if (a.y != b.y) return a.y > b.y;
        if (a.z != b.z) return a.z > b.z;
    }
    return false;
}

Vec3 curved_curve_point(const CurvedControl control[4], double t) {
    if (t == 0 || t == 1) return control[t == 1 ? 3 : 0].point;
    bool turned = begins_behind(control);
    double b[4];
    bernstein(turned ? 1 - t : t, b);
    Homogeneous sum = {{0, 0, 0}, 0};
    for (int i = 0; i < 4; i++) add_weighted_control(&sum, b[i], &control[turned ? 3 - i : i]);
    return vec3_scale(sum.x, 1 / sum.w);
}

Vec2 curved_trim_point(const CurvedTrim *trim, double t) {
    if (t == 0 || t == 1) return trim->point[t == 1 ? 3 : 0];
    double b[4], w = 0;
    Vec2 sum = {0, 0};
    bernstein(t, b);
    for (int i = 0; i < 4; i++) {
        sum = vec2_add(sum, vec2_scale(trim->point[i], b[i] * trim->weight[i]));
        w += b[i] * trim->weight[i];
    }
    return vec2_scale(sum, 1 / w);
}
