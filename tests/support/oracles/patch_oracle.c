// patch_oracle.c - all hits of a ray with a patch, from a dense grid and Newton's steps in long doubles.
#include "tests/support/oracles/patch_oracle.h"

// Cells are looked at as if they were so large, in halves of them, for what bends between their corners.
#define GROWN 2.0
// Roots nearer to each other are one, in parameter.
#define SAME 1e-8
// Roots so near, in parameter, may be found as a double one: the sheet between them leaves the ray by some 1e-12 of its size,
// a few times what the ray itself is rounded to.
#define TWINS 5e-6
// At a fold: the ray's angle with the surface, as a sine; at the border: the parameter's distance.
#define FOLD 3e-5
#define BORDER 1e-10

typedef long double Real;
typedef struct Real3 {
    Real x, y, z;
} Real3;

struct PatchOracle {
    Real3 point[16];  // about the centre, multiplied by their weights
    Real weight[16];
    Vec3 centre;
    double size;
    int cells;
    Vec3 *grid;  // [(cells + 1)^2]
};

static void basis(Real s, Real b[4], Real d[4]) {
    Real r = 1 - s;
    b[0] = r * r * r, b[1] = 3 * r * r * s, b[2] = 3 * r * s * s, b[3] = s * s * s;
    d[0] = -3 * r * r, d[1] = 3 * r * r - 6 * r * s, d[2] = 6 * r * s - 3 * s * s, d[3] = 3 * s * s;
}

static Real3 scaled(Real3 a, Real s) { return (Real3){a.x * s, a.y * s, a.z * s}; }
static Real3 added(Real3 a, Real3 b) { return (Real3){a.x + b.x, a.y + b.y, a.z + b.z}; }
static Real dot(Real3 a, Real3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static Real3 real(Vec3 a) { return (Real3){a.x, a.y, a.z}; }

// About the centre.
static Real3 point(const PatchOracle *o, Real u, Real v, Real3 *du, Real3 *dv) {
    Real bu[4], su[4], bv[4], sv[4], w = 0, wu = 0, wv = 0;
    Real3 p = {0}, pu = {0}, pv = {0};
    basis(u, bu, su);
    basis(v, bv, sv);
    for (int k = 0; k < 16; k++) {
        Real3 q = o->point[k];
        Real b = bu[k % 4] * bv[k / 4], s = su[k % 4] * bv[k / 4], t = bu[k % 4] * sv[k / 4];
        p = added(p, scaled(q, b)), pu = added(pu, scaled(q, s)), pv = added(pv, scaled(q, t));
        w += b * o->weight[k], wu += s * o->weight[k], wv += t * o->weight[k];
    }
    p = scaled(p, 1 / w);
    *du = scaled(added(pu, scaled(p, -wu)), 1 / w);
    *dv = scaled(added(pv, scaled(p, -wv)), 1 / w);
    return p;
}

static Vec3 plain(Real3 a) { return vec3((double)a.x, (double)a.y, (double)a.z); }

Vec3 patch_oracle_point(const PatchOracle *o, double u, double v, Vec3 *du, Vec3 *dv) {
    Real3 pu, pv;
    Vec3 p = plain(point(o, (Real)u, (Real)v, &pu, &pv));
    if (du) *du = plain(pu);
    if (dv) *dv = plain(pv);
    return vec3_add(p, o->centre);
}

double patch_oracle_size(const PatchOracle *o) { return o->size; }

PatchOracle *patch_oracle_new(const Building *building, int cells, Arena *arena) {
    PatchOracle *o = ARENA_ARRAY(arena, PatchOracle, 1);
    const CurvedControl *control = building->controls;
    Box box = box_empty();
    for (int k = 0; k < 16; k++) box = box_add(box, control[k].point);
    o->centre = vec3_lerp(box.min, box.max, 0.5);
    for (int k = 0; k < 16; k++) {
        o->weight[k] = (Real)control[k].weight;
        o->point[k] = scaled(added(real(control[k].point), scaled(real(o->centre), -1)), o->weight[k]);
    }
    o->size = vec3_length(vec3_sub(box.max, box.min));
    o->cells = cells;
    o->grid = ARENA_ARRAY(arena, Vec3, (cells + 1) * (cells + 1));
    for (int i = 0; i <= cells; i++)
        for (int k = 0; k <= cells; k++) {
            Real3 du, dv;
            o->grid[i * (cells + 1) + k] = plain(point(o, k / (Real)cells, i / (Real)cells, &du, &dv));
        }
    return o;
}

static void axes_across(Vec3 d, Vec3 n[2]) {
    Vec3 least = fabs(d.x) < fabs(d.y) ? vec3(1, 0, 0) : vec3(0, 1, 0);
    if (fabs(d.z) < fabs(vec3_dot(d, least))) least = vec3(0, 0, 1);
    n[0] = vec3_normalize(vec3_cross(d, least));
    n[1] = vec3_cross(d, n[0]);
}

bool patch_oracle_refine(const PatchOracle *o, const Ray *ray, double start_u, double start_v,
                         OracleRoot *out) {
    Vec3 n[2];
    axes_across(ray->direction, n);
    Real3 a = real(n[0]), b = real(n[1]), d = real(ray->direction);
    Real3 from = added(real(ray->origin), scaled(real(o->centre), -1));
    Real u = (Real)start_u, v = (Real)start_v;
    for (int i = 0; i < 30; i++) {
        Real3 du, dv, p = added(point(o, u, v, &du, &dv), scaled(from, -1));
        Real f = dot(a, p), g = dot(b, p), fu = dot(a, du), fv = dot(a, dv), gu = dot(b, du), gv = dot(b, dv);
        Real det = fu * gv - fv * gu, step_u = (fv * g - gv * f) / det, step_v = (gu * f - fu * g) / det;
        u += step_u, v += step_v;
        if (!(u > -0.5L && u < 1.5L && v > -0.5L && v < 1.5L)) return false;
        if (fabsl(step_u) + fabsl(step_v) > 1e-15L) continue;
        if (u < -1e-12L || v < -1e-12L || u > 1 + 1e-12L || v > 1 + 1e-12L) return false;
        p = added(point(o, u, v, &du, &dv), scaled(from, -1));
        Vec3 tu = plain(du), tv = plain(dv), normal = vec3_normalize(vec3_cross(tu, tv));
        double border = fmin(fmin((double)u, (double)v), fmin((double)(1 - u), (double)(1 - v)));
        *out = (OracleRoot){(double)u, (double)v, (double)dot(d, p),
                            fabs(vec3_dot(normal, ray->direction)) > FOLD && border > BORDER};
        return fabsl(dot(a, p)) + fabsl(dot(b, p)) < 1e-14L * (Real)o->size;
    }
    return false;
}

static void add(OracleRoot *roots, int *count, OracleRoot root) {
    for (int i = 0; i < *count; i++) {
        double apart = fabs(roots[i].u - root.u) + fabs(roots[i].v - root.v);
        if (apart < SAME) return;
        if (apart < TWINS) roots[i].sure = root.sure = false;
    }
    if (*count < ORACLE_ROOTS) roots[(*count)++] = root;
}

// Where the ray passes a cell, by its corners in the plane across the ray, in cells from its middle. False: it does not, by far.
// `folds`: it may pass more than once.
static bool passes(const Vec2 c[4], Vec2 *at, bool *folds) {
    Vec2 mean = vec2_scale(vec2_add(vec2_add(c[0], c[1]), vec2_add(c[2], c[3])), 0.25), grow = {0};
    for (int k = 0; k < 4; k++)
        grow = vec2(fmax(grow.x, fabs(c[k].x - mean.x)), fmax(grow.y, fabs(c[k].y - mean.y)));
    if (fabs(mean.x) > GROWN * grow.x || fabs(mean.y) > GROWN * grow.y) return false;
    Vec2 u = vec2_scale(vec2_sub(vec2_add(c[1], c[3]), vec2_add(c[0], c[2])), 0.5);
    Vec2 v = vec2_scale(vec2_sub(vec2_add(c[2], c[3]), vec2_add(c[0], c[1])), 0.5);
    double det = vec2_cross(u, v);
    *folds = fabs(det) < 0.1 * vec2_length(u) * vec2_length(v);
    *at = vec2(vec2_cross(v, mean) / det, vec2_cross(mean, u) / det);
    return *folds || (fabs(at->x) < GROWN && fabs(at->y) < GROWN);
}

int patch_oracle_roots(const PatchOracle *o, const Ray *ray, OracleRoot out[ORACLE_ROOTS]) {
    Vec3 n[2], from = vec3_sub(ray->origin, o->centre);
    axes_across(ray->direction, n);
    Vec2 e = {vec3_dot(n[0], from), vec3_dot(n[1], from)};
    int count = 0, row = o->cells + 1;
    for (int i = 0; i < o->cells * row; i++) {
        if (i % row == o->cells) continue;
        const int corners[4] = {i, i + 1, i + row, i + row + 1};
        Vec2 corner[4], at;
        for (int k = 0; k < 4; k++) {
            const Vec3 *p = &o->grid[corners[k]];
            corner[k] = vec2(vec3_dot(n[0], *p) - e.x, vec3_dot(n[1], *p) - e.y);
        }
        bool folds;
        if (!passes(corner, &at, &folds)) continue;
        for (int k = 0; k < (folds ? 5 : 1); k++) {  // where it folds, from the middle and the corners
            double u = i % row + 0.5, v = i / row + 0.5;
            u += folds ? (k < 4 ? k % 2 - 0.5 : 0) : at.x;
            v += folds ? (k < 4 ? k / 2 - 0.5 : 0) : at.y;
            OracleRoot root;
            if (patch_oracle_refine(o, ray, u / o->cells, v / o->cells, &root)) add(out, &count, root);
        }
    }
    return count;
}
