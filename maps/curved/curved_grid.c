// curved_grid.c - a whole patch as polygons: a grid, as fine as its bend asks for, and along each border that is divided
// otherwise than the grid a strip of triangles, so that neighbours meet there without cracks.
#include "engine/core/polygon.h"
#include "maps/curved/curved_patch.h"
#include "maps/curved/curved_tessellate.h"

typedef struct Knot {
    Vec2 at;  // parameters
    Vec3 p;
} Knot;

typedef struct Grid {
    const CurvedControl *control;
    double tolerance;
    int nu, nv;
    Knot *knots;                            // [(nv + 1) (nu + 1)] rows of v
    int steps[4];                           // of the borders, see curved_patch_border
    Knot border[4][CURVED_MOST_STEPS + 1];  // in the direction of u or v
    bool strip[4];                          // divided otherwise than the grid
    double worst;                           // found off the strips, metres
    Arena *arena;
    CurvedMesh *out;
} Grid;

static Vec2 border_at(int border, double t) {
    return border == 0 ? vec2(t, 0) : border == 1 ? vec2(1, t) : border == 2 ? vec2(t, 1) : vec2(0, t);
}

static void find_borders(Grid *g) {
    for (int e = 0; e < 4; e++) {
        CurvedControl curve[4];
        curved_patch_border(g->control, e, curve);
        int n = g->steps[e] = curved_border_steps(curve, g->tolerance);
        for (int i = 0; i <= n; i++) {
            double t = curved_step(i, n);
            g->border[e][i] = (Knot){border_at(e, t), curved_curve_point(curve, t)};
        }
    }
}

static void find_strips(Grid *g) {
    bool any = false;
    for (int e = 0; e < 4; e++) any |= g->steps[e] != (e % 2 ? g->nv : g->nu);
    // Between strips on both sides something must be left.
    if (any && g->nu < 2) g->nu = 2;
    if (any && g->nv < 2) g->nv = 2;
    for (int e = 0; e < 4; e++) g->strip[e] = g->steps[e] != (e % 2 ? g->nv : g->nu);
}

static Knot *knot(const Grid *g, int i, int j) { return &g->knots[j * (g->nu + 1) + i]; }

static void find_knots(Grid *g) {
    g->knots = ARENA_ARRAY(g->arena, Knot, (g->nu + 1) * (g->nv + 1));
    for (int j = 0; j <= g->nv; j++) {
        for (int i = 0; i <= g->nu; i++) {
            Vec2 at = vec2(curved_step(i, g->nu), curved_step(j, g->nv));
            *knot(g, i, j) = (Knot){at, curved_patch_point(g->control, at.x, at.y)};
        }
    }
    for (int i = 0; i <= g->nu; i++) {
        if (!g->strip[0]) *knot(g, i, 0) = g->border[0][i];
        if (!g->strip[2]) *knot(g, i, g->nv) = g->border[2][i];
    }
    for (int j = 0; j <= g->nv; j++) {
        if (!g->strip[1]) *knot(g, g->nu, j) = g->border[1][j];
        if (!g->strip[3]) *knot(g, 0, j) = g->border[3][j];
    }
}

// ---- polygons

// How far the patch lies off the triangle at four of its points.
static double off_triangle(const Grid *g, const Knot t[3]) {
    Plane plane = plane_of_polygon((Vec3[]){t[0].p, t[1].p, t[2].p}, 3);
    if (vec3_length(plane.n) == 0) return 0;
    static const double SHARES[4][3] = {
        {1. / 3, 1. / 3, 1. / 3}, {0.5, 0.5, 0}, {0, 0.5, 0.5}, {0.5, 0, 0.5}};
    double worst = 0;
    for (int s = 0; s < 4; s++) {
        Vec2 at = {0, 0};
        for (int k = 0; k < 3; k++) at = vec2_add(at, vec2_scale(t[k].at, SHARES[s][k]));
        worst = fmax(worst, fabs(plane_distance(plane, curved_patch_point(g->control, at.x, at.y))));
    }
    return worst;
}

static void add_triangle(Grid *g, Knot a, Knot b, Knot c, bool flip) {
    Knot t[3] = {a, b, c};
    g->worst = fmax(g->worst, off_triangle(g, t));
    curved_mesh_add(g->out, g->arena, (Vec3[]){a.p, b.p, c.p}, 3, flip);
}

static double knot_along_border(const Knot *k, int border) { return border % 2 ? k->at.y : k->at.x; }

// Triangles between a border and the row of knots beside it, from its one end to the other.
static void add_strip(Grid *g, int e, const int low[2], const int high[2]) {
    Knot inner[CURVED_MOST_STEPS + 1];
    int axis = e % 2, n = high[axis] - low[axis], m = g->steps[e];
    for (int i = 0; i <= n; i++) {
        int k = low[axis] + i;
        inner[i] = e == 0   ? *knot(g, k, low[1])
                   : e == 1 ? *knot(g, high[0], k)
                   : e == 2 ? *knot(g, k, high[1])
                            : *knot(g, low[0], k);
    }
    const Knot *outer = g->border[e];
    bool flip = e >= 2;
    for (int a = 0, b = 0; a < m || b < n;) {
        bool out =
            b == n || (a < m && knot_along_border(&outer[a], e) + knot_along_border(&outer[a + 1], e) <=
                                    knot_along_border(&inner[b], e) + knot_along_border(&inner[b + 1], e));
        add_triangle(g, outer[a], out ? outer[a + 1] : inner[b + 1], inner[b], flip);
        if (out) {
            a++;
        } else {
            b++;
        }
    }
}

static void add_all(Grid *g) {
    const int low[2] = {g->strip[3], g->strip[0]}, high[2] = {g->nu - g->strip[1], g->nv - g->strip[2]};
    for (int j = low[1]; j < high[1]; j++) {
        for (int i = low[0]; i < high[0]; i++)
            curved_mesh_add_quad(g->out, g->arena,
                                 (Vec3[]){knot(g, i, j)->p, knot(g, i + 1, j)->p, knot(g, i + 1, j + 1)->p,
                                          knot(g, i, j + 1)->p});
    }
    for (int e = 0; e < 4; e++)
        if (g->strip[e]) add_strip(g, e, low, high);
}

void curved_patch_mesh(const CurvedControl *control, double tolerance, Arena *arena, CurvedMesh *out) {
    Grid *g = ARENA_ARRAY(arena, Grid, 1);
    *g = (Grid){.control = control, .tolerance = tolerance, .arena = arena, .out = out};
    find_borders(g);
    double off = curved_patch_steps(control, tolerance, &g->nu, &g->nv);
    for (;;) {
        *out = (CurvedMesh){0};
        g->worst = 0;
        find_strips(g);
        find_knots(g);
        add_all(g);
        if (g->worst <= tolerance || (g->nu == CURVED_MOST_STEPS && g->nv == CURVED_MOST_STEPS)) break;
        g->nu = curved_finer_steps(g->nu);
        g->nv = curved_finer_steps(g->nv);
    }
    out->tolerance = fmax(off, g->worst);
}
