// curved_bend.c - how far patches and curves lie off the polygons between their points, at most.
//
// The bound is that of second differences (D. Filip, R. Magedson & R. Markot, Surface algorithms using bounds on derivatives,
// 1986), for rational patches with the weight as a fourth coordinate: if X / W is the patch and X' / W' the point of the triangle
// with the same weights, their distance is (X - X' + (W' - W) X' / W') / W, which is at most
// (|X - X'| + r |W - W'|) / least weight, r being how far controls lie off the middle of their box (J. Zheng & T. Sederberg,
// Estimating tessellation parameter intervals for rational curves and surfaces, 2000). Where the steps allow, the patch is halved
// once or twice each way first: differences of its parts are nearer to its derivatives.
#include <string.h>

#include "maps/curved/curved_patch.h"
#include "maps/curved/curved_tessellate.h"

// Steps along a patch or a border.
static const int STEPS[] = {1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64};
enum { STEP_COUNT = sizeof STEPS / sizeof *STEPS };
_Static_assert(CURVED_MOST_STEPS == 64, "the last of STEPS");

// Borders keep this share of the tolerance, since the triangles of a strip lie off the patch too.
static const double BORDER_SHARE = 0.5;

// A patch lies off a triangle with legs du and dv in its parameters by at most (du^2 uu + 2 du dv uv + dv^2 vv) / 8.
typedef struct PatchBend {
    double uu, uv, vv;  // metres
} PatchBend;
// [i][j]: the most of its parts, the patch halved i times along u and j times along v.
enum { BEND_LEVELS = 3 };
typedef struct PatchBends {
    PatchBend level[BEND_LEVELS][BEND_LEVELS];
} PatchBends;

typedef struct Homogeneous {
    Vec3 x;  // times the weight
    double w;
} Homogeneous;

static Homogeneous of_control(const CurvedControl *c) {
    return (Homogeneous){vec3_scale(c->point, c->weight), c->weight};
}

static CurvedControl middle_of_controls(CurvedControl a, CurvedControl b) {
    double w = a.weight + b.weight;
    Vec3 sum = vec3_add(vec3_scale(a.point, a.weight), vec3_scale(b.point, b.weight));
    return (CurvedControl){vec3_scale(sum, 1 / w), w / 2};
}

// Replaces a curve, its controls `step` apart, by its lower or upper half (de Casteljau).
static void halve_patch(CurvedControl *c, int step, bool upper) {
    CurvedControl p[4] = {c[0], c[step], c[2 * step], c[3 * step]};
    CurvedControl a = middle_of_controls(p[0], p[1]), b = middle_of_controls(p[1], p[2]),
                  d = middle_of_controls(p[2], p[3]), ab = middle_of_controls(a, b),
                  bd = middle_of_controls(b, d), all = middle_of_controls(ab, bd);
    c[0] = upper ? all : p[0];
    c[step] = upper ? bd : a;
    c[2 * step] = upper ? d : ab;
    c[3 * step] = upper ? p[3] : all;
}

// Controls about the middle of their box; returns how far they reach.
static double centred(const CurvedControl *control, int count, Homogeneous *out, double *least) {
    Box box = box_empty();
    double reach = 0;
    *least = INFINITY;
    for (int i = 0; i < count; i++) box = box_add(box, control[i].point);
    Vec3 middle = vec3_scale(vec3_add(box.min, box.max), 0.5);
    for (int i = 0; i < count; i++) {
        CurvedControl c = {vec3_sub(control[i].point, middle), control[i].weight};
        out[i] = of_control(&c);
        reach = fmax(reach, vec3_length(c.point));
        *least = fmin(*least, c.weight);
    }
    return reach;
}

static double second(Homogeneous a, Homogeneous b, Homogeneous c, double reach) {
    Vec3 x = vec3_add(vec3_sub(a.x, vec3_scale(b.x, 2)), c.x);
    return vec3_length(x) + reach * fabs(a.w - 2 * b.w + c.w);
}

static double mixed(Homogeneous a, Homogeneous b, Homogeneous c, Homogeneous d, double reach) {
    Vec3 x = vec3_sub(vec3_sub(a.x, b.x), vec3_sub(c.x, d.x));
    return vec3_length(x) + reach * fabs(a.w - b.w - c.w + d.w);
}

static PatchBend bend_of(const CurvedControl control[PATCH_CONTROLS]) {
    Homogeneous h[PATCH_CONTROLS];
    double least, reach = centred(control, PATCH_CONTROLS, h, &least);
    PatchBend bend = {0, 0, 0};
    for (int j = 0; j < 4; j++) {
        for (int i = 0; i < 2; i++) {
            const Homogeneous *u = &h[4 * j + i], *v = &h[4 * i + j];
            bend.uu = fmax(bend.uu, 6 * second(u[0], u[1], u[2], reach) / least);
            bend.vv = fmax(bend.vv, 6 * second(v[0], v[4], v[8], reach) / least);
        }
    }
    for (int j = 0; j < 3; j++) {
        for (int i = 0; i < 3; i++) {
            const Homogeneous *p = &h[4 * j + i];
            bend.uv = fmax(bend.uv, 9 * mixed(p[0], p[1], p[4], p[5], reach) / least);
        }
    }
    return bend;
}

static double curve_bend(const CurvedControl control[4]) {
    Homogeneous h[4];
    double least, reach = centred(control, 4, h, &least);
    double bend = fmax(second(h[0], h[1], h[2], reach), second(h[1], h[2], h[3], reach));
    return 6 * bend / least;
}

// The part (i, j) of 2^u x 2^v.
static void part_of(const CurvedControl *control, int u, int v, int i, int j, CurvedControl *out) {
    memcpy(out, control, PATCH_CONTROLS * sizeof *out);
    for (int level = u - 1; level >= 0; level--)
        for (int k = 0; k < 4; k++) halve_patch(out + 4 * k, 1, i >> level & 1);
    for (int level = v - 1; level >= 0; level--)
        for (int k = 0; k < 4; k++) halve_patch(out + k, 4, j >> level & 1);
}

static PatchBends patch_bends(const CurvedControl control[PATCH_CONTROLS]) {
    PatchBends bends;
    for (int u = 0; u < BEND_LEVELS; u++) {
        for (int v = 0; v < BEND_LEVELS; v++) {
            PatchBend most = {0, 0, 0};
            for (int part = 0; part < 1 << (u + v); part++) {
                CurvedControl piece[PATCH_CONTROLS];
                part_of(control, u, v, part & ((1 << u) - 1), part >> u, piece);
                PatchBend bend = bend_of(piece);
                most.uu = fmax(most.uu, bend.uu);
                most.uv = fmax(most.uv, bend.uv);
                most.vv = fmax(most.vv, bend.vv);
            }
            // In steps of the whole patch.
            double du = 1 << u, dv = 1 << v;
            bends.level[u][v] = (PatchBend){most.uu * du * du, most.uv * du * dv, most.vv * dv * dv};
        }
    }
    return bends;
}

// How often so many steps can be halved.
static int level_of(int steps) {
    int level = 0;
    while (level + 1 < BEND_LEVELS && steps % (2 << level) == 0) level++;
    return level;
}

// The most that so many equal steps along u and v leave between the patch and flat pieces, metres.
static double patch_off(const PatchBends *bends, int u, int v) {
    const PatchBend *b = &bends->level[level_of(u)][level_of(v)];
    double du = 1.0 / u, dv = 1.0 / v;
    return (du * du * b->uu + 2 * du * dv * b->uv + dv * dv * b->vv) / 8;
}

// The same between a curve and its chords.
static double curve_off(const CurvedControl control[4], int steps) {
    int level = level_of(steps);
    double most = 0, step = (double)(1 << level) / steps;
    for (int part = 0; part < 1 << level; part++) {
        CurvedControl piece[4];
        memcpy(piece, control, sizeof piece);
        for (int k = level - 1; k >= 0; k--) halve_patch(piece, 1, part >> k & 1);
        most = fmax(most, curve_bend(piece));
    }
    return most * step * step / 8;
}

double curved_patch_steps(const CurvedControl *control, double tolerance, int *u, int *v) {
    PatchBends bends = patch_bends(control);
    const int last = STEP_COUNT - 1;
    int i = 0, j = 0;
    for (;;) {
        double off = patch_off(&bends, STEPS[i], STEPS[j]);
        *u = STEPS[i];
        *v = STEPS[j];
        if (off <= tolerance || (i == last && j == last)) return off;
        // The way that gains more.
        double along = i < last ? patch_off(&bends, STEPS[i + 1], STEPS[j]) : INFINITY,
               across = j < last ? patch_off(&bends, STEPS[i], STEPS[j + 1]) : INFINITY;
        *(along < across || (along == across && i <= j) ? &i : &j) += 1;
    }
}

int curved_border_steps(const CurvedControl border[4], double tolerance) {
    int i = 0;
    while (i + 1 < STEP_COUNT && curve_off(border, STEPS[i]) > BORDER_SHARE * tolerance) i++;
    return STEPS[i];
}

int curved_finer_steps(int steps) {
    int i = 0;
    while (i + 1 < STEP_COUNT && STEPS[i] <= steps) i++;
    return STEPS[i];
}
