// ray_patches.c - patches on which intersections with rays are measured and tested.
#include "engine/bench/ray_patches.h"

const char *const RAY_PATCH_NAMES[RAY_PATCHES] = {"flat",   "saddle", "waves", "fold", "loop",    "spike",
                                                  "sphere", "torus",  "vase",  "edge", "weights", "trimmed"};

// Heights over a grid: rows of v.
static const double SADDLE[16] = {0, 0.5, 0.5, 0, -0.5, 0, 0, -0.5, -0.5, 0, 0, -0.5, 0, 0.5, 0.5, 0};
static const double WAVES[16] = {-0.9, 1,   -1.1, 1.3, 1,   -1.2, 1.4, -1,
                                 -1,   1.5, -1.3, 1.1, 0.8, -1,   1.2, -0.7};
static const double SPIKE[16] = {0, 0, 0, 0, 0, 0, 6, 0, 0, -1, 0, 0, 0, 0, 0, 0};

static void set(CurvedControl *c, double x, double y, double z, double w) {
    *c = (CurvedControl){vec3(x, y, z), w};
}

static void heights(CurvedControl c[16], const double z[16]) {
    for (int k = 0; k < 16; k++) set(&c[k], (k % 4) * (2 / 3.0) - 1, (k / 4) * (2 / 3.0) - 1, z[k], 1);
}

// The quarter of a circle as a rational cubic: an arc of degree 2 and weights 1, sqrt(1/2), 1, raised by one.
static void quarter(int k, double *x, double *y, double *w) {
    static const double X[3] = {1, 1, 0}, Y[3] = {0, 1, 1};
    const double W[3] = {1, M_SQRT1_2, 1};
    double a = k == 0 ? 0 : k == 3 ? 1 : k / 3.0;  // the share of the control point before
    int i = k == 0 ? 0 : k - 1, j = k == 3 ? 2 : k;
    *w = a * W[i] + (1 - a) * W[j];
    *x = (a * X[i] * W[i] + (1 - a) * X[j] * W[j]) / *w;
    *y = (a * Y[i] * W[i] + (1 - a) * Y[j] * W[j]) / *w;
}

typedef struct Profile {
    double radius, height, weight;
} Profile;

// Turned a quarter about z.
static void lathe(CurvedControl c[16], const Profile profile[4]) {
    for (int k = 0; k < 16; k++) {
        double x, y, w;
        quarter(k % 4, &x, &y, &w);
        const Profile *row = &profile[k / 4];
        set(&c[k], x * row->radius, y * row->radius, row->height, w * row->weight);
    }
}

static void sphere(CurvedControl c[16], double across, double radius) {
    Profile profile[4];
    for (int i = 0; i < 4; i++) {
        quarter(i, &profile[i].radius, &profile[i].height, &profile[i].weight);
        profile[i].radius = across + radius * profile[i].radius;
        profile[i].height *= radius;
    }
    lathe(c, profile);
}

// Bent over itself along u: three hits and more; `turn` makes it cross itself.
static void fold(CurvedControl c[16], double turn) {
    static const double X[4] = {-1, 1.8, -1.8, 1};
    for (int k = 0; k < 16; k++) {
        int u = k % 4, v = k / 4;
        set(&c[k], X[u] + 0.1 * v, v * (2 / 3.0) - 1, (u - 1.5) * 0.4 * (1 - turn * v), 1);
    }
}

static void edge(CurvedControl c[16]) {  // nearly a crease along the middle
    static const double Z[4] = {-1, 1, 1, -1};
    static const double X[4] = {-0.4, -0.01, 0.01, 0.4};
    for (int k = 0; k < 16; k++) set(&c[k], X[k % 4], (k / 4) * (2 / 3.0) - 1, Z[k % 4], 1);
}

static void controls_of(int patch, CurvedControl c[16]) {
    static const Profile VASE[4] = {{0, -1, 1}, {1.6, -0.9, 1}, {-0.2, 0.4, 1}, {0.7, 1, 1}};
    static const double FLAT[16] = {0};
    switch (patch) {
    case 0:
        heights(c, FLAT);
        break;
    case 1:
        heights(c, SADDLE);
        break;
    case 2:
    case 10:
    case 11:
        heights(c, WAVES);
        break;
    case 3:
        fold(c, 0);
        break;
    case 4:
        fold(c, 0.6);
        break;
    case 5:
        heights(c, SPIKE);
        break;
    case 6:
        sphere(c, 0, 1);
        break;
    case 7:
        sphere(c, 0.7, 0.4);
        break;
    case 8:
        lathe(c, VASE);
        break;
    default:
        edge(c);
    }
    for (int k = 0; k < 16 && patch == 10; k++) c[k].weight = k == 5 ? 8 : k == 6 ? 0.2 : k == 10 ? 5 : 1;
}

// A circle as four curves.
static void add_circle(Building *b, Arena *arena, Vec2 centre, double radius) {
    for (int side = 0; side < 4; side++) {
        CurvedTrim *trim = ARENA_PUSH(arena, b->trims, b->trim_count, b->trim_capacity);
        for (int k = 0; k < 4; k++) {
            double x, y;
            quarter(k, &x, &y, &trim->weight[k]);
            for (int turn = 0; turn < side; turn++) {
                double swap = x;
                x = -y, y = swap;
            }
            trim->point[k] = vec2(centre.x + radius * x, centre.y + radius * y);
        }
    }
}

static void add_trims(Building *b, Arena *arena) {
    add_circle(b, arena, vec2(0.5, 0.5), 0.45);
    add_circle(b, arena, vec2(0.4, 0.55), 0.2);
    add_circle(b, arena, vec2(0.75, 0.3), 0.1);
}

Building ray_patch_building(int patch, double scale, Arena *arena) {
    Building b = {0};
    CurvedControl c[16];
    controls_of(patch, c);
    for (int k = 0; k < 16; k++) {
        c[k].point = vec3_scale(c[k].point, scale);
        *ARENA_PUSH(arena, b.controls, b.control_count, b.control_capacity) = c[k];
    }
    if (patch == RAY_PATCHES - 1) add_trims(&b, arena);
    CurvedShape *shape = ARENA_PUSH(arena, b.shapes, b.shape_count, b.shape_capacity);
    *shape = (CurvedShape){.kind = CURVED_PATCH, .trim_count = b.trim_count, .tolerance = 0.001};
    return b;
}
