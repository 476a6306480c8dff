// curved_balls.c - metaballs as triangles, by marching tetrahedra (A. Doi & A. Koide, An efficient method of triangulating
// equi-valued surfaces by using tetrahedral cells, 1991): a grid of cubes, each six tetrahedra about its diagonal, whose
// vertices lie in the surface or out of it; every one that is cut gives a triangle or two.
//
// Beyond the paper: corners of triangles are brought onto the surface by Newton's method; and vertices of the grid that lie
// near it are moved onto it beforehand and count as outside (F. Labelle & J. Shewchuk, Isosurface stuffing, 2007), which leaves
// no slivers. The grid is made finer until the triangles are found to lie within the tolerance.
#include "maps/curved/curved_field.h"
#include "maps/curved/curved_tessellate.h"

// Steps of the coarsest grid: along the box, and across the radius of the smallest ball.
enum { LEAST_CELLS = 6, BALL_CELLS = 3 };
// A vertex of the grid nearer to the surface than this share of a step lies on it.
static const double NEAR = 0.2;
// The next grid is made for this share of the tolerance.
static const double AIM = 0.7;

typedef struct Field {
    const CurvedBall *balls;
    int count;
    double threshold;
} Field;

typedef struct Vertex {
    Vec3 p;
    double over;  // field - threshold; above 0 within, 0 on the surface
} Vertex;

typedef struct March {
    Field field;
    Vec3 origin;
    double step;
    int n[3];          // cubes along x, y, z
    Vertex *layer[2];  // [(n.y + 1) (n.x + 1)] of this z and the next
    double worst;
    Arena *arena;
    CurvedMesh *out;
} March;

static void settle_on_surface(const March *m, Vec3 *p) {
    curved_field_settle(m->field.balls, m->field.count, m->field.threshold, m->step, p);
}

static void find_layer(const March *m, int k, Vertex *layer) {
    for (int j = 0; j <= m->n[1]; j++) {
        for (int i = 0; i <= m->n[0]; i++) {
            Vertex *v = layer++;
            Vec3 gradient;
            *v = (Vertex){.p = vec3_add(m->origin, vec3_scale(vec3(i, j, k), m->step))};
            v->over =
                curved_field_gradient(m->field.balls, m->field.count, v->p, &gradient) - m->field.threshold;
            if (fabs(v->over) > NEAR * m->step * vec3_length(gradient)) continue;
            Vec3 on = v->p;
            bool there = curved_field_settle(m->field.balls, m->field.count, m->field.threshold,
                                             2 * NEAR * m->step, &on);
            if (there) *v = (Vertex){on, 0};
        }
    }
}

// Where the edge from `in` to `out` leaves the surface: halved down, since the field need not be monotonous, then settled.
static Vec3 threshold_on_edge(const March *m, const Vertex *in, const Vertex *out) {
    enum { HALVINGS = 8 };
    if (out->over == 0) return out->p;
    // The same point whichever tetrahedron asks: both ends are the grid's.
    double low = 0, high = 1;
    for (int i = 0; i < HALVINGS; i++) {
        double middle = (low + high) / 2;
        Vec3 p = vec3_lerp(in->p, out->p, middle);
        bool within = curved_field(m->field.balls, m->field.count, p) > m->field.threshold;
        *(within ? &low : &high) = middle;
    }
    Vec3 p = vec3_lerp(in->p, out->p, (low + high) / 2);
    settle_on_surface(m, &p);
    return p;
}

static void add_triangle(March *m, Vec3 a, Vec3 b, Vec3 c) {
    if (vec3_equal(a, b) || vec3_equal(b, c) || vec3_equal(c, a)) return;
    Vec3 inside[4] = {vec3_scale(vec3_add(a, vec3_add(b, c)), 1. / 3), vec3_lerp(a, b, 0.5),
                      vec3_lerp(b, c, 0.5), vec3_lerp(c, a, 0.5)};
    for (int i = 0; i < 4; i++) {
        Vec3 on = inside[i];
        settle_on_surface(m, &on);
        m->worst = fmax(m->worst, vec3_length(vec3_sub(on, inside[i])));
    }
    curved_mesh_add(m->out, m->arena, (Vec3[]){a, b, c}, 3, false);
}

// The vertices within come first, the others after them; whether that takes an odd number of swaps.
static bool order(const Vertex *v[4], int *within) {
    const Vertex *sorted[4];
    int swaps = 0, in = 0, out = 0;
    for (int i = 0; i < 4; i++) in += v[i]->over > 0;
    *within = in;
    in = 0;
    for (int i = 0; i < 4; i++) {
        bool inside = v[i]->over > 0;
        if (inside) swaps += out;
        sorted[inside ? in++ : *within + out++] = v[i];
    }
    memcpy(v, sorted, sizeof sorted);
    return swaps % 2;
}

// v[1], v[2] and v[3] turn left seen from beyond them, unless `odd`.
static void march_tetrahedron(March *m, const Vertex *v[4], bool odd) {
    int within;
    odd ^= order(v, &within);
    if (within == 0 || within == 4) return;
    Vec3 c[4];
    if (within == 1) {
        for (int i = 0; i < 3; i++) c[i] = threshold_on_edge(m, v[0], v[i + 1]);
    } else if (within == 3) {
        for (int i = 0; i < 3; i++) c[i] = threshold_on_edge(m, v[i], v[3]);
    } else {
        static const unsigned char EDGE[4][2] = {{0, 2}, {0, 3}, {1, 3}, {1, 2}};
        for (int i = 0; i < 4; i++) c[i] = threshold_on_edge(m, v[EDGE[i][0]], v[EDGE[i][1]]);
        add_triangle(m, c[0], c[odd ? 3 : 2], c[odd ? 2 : 3]);
    }
    add_triangle(m, c[0], c[odd ? 2 : 1], c[odd ? 1 : 2]);
}

// The six tetrahedra go from corner 0 to corner 7 along the three axes in any order.
static void march_cube(March *m, const Vertex *corner[8]) {
    static const unsigned char AXES[6][2] = {{1, 2}, {2, 4}, {4, 1}, {2, 1}, {4, 2}, {1, 4}};
    int within = 0;
    for (int i = 0; i < 8; i++) within += corner[i]->over > 0;
    if (within == 0 || within == 8) return;
    for (int t = 0; t < 6; t++) {
        const Vertex *v[4] = {corner[0], corner[AXES[t][0]], corner[AXES[t][0] + AXES[t][1]], corner[7]};
        march_tetrahedron(m, v, t >= 3);
    }
}

static void march(March *m) {
    int row = m->n[0] + 1;
    *m->out = (CurvedMesh){0};
    m->worst = 0;
    find_layer(m, 0, m->layer[0]);
    for (int k = 0; k < m->n[2]; k++) {
        find_layer(m, k + 1, m->layer[1]);
        for (int j = 0; j < m->n[1]; j++) {
            for (int i = 0; i < m->n[0]; i++) {
                const Vertex *corner[8];
                for (int c = 0; c < 8; c++)
                    corner[c] = &m->layer[c >> 2][(j + (c >> 1 & 1)) * row + i + (c & 1)];
                march_cube(m, corner);
            }
        }
        Vertex *last = m->layer[0];
        m->layer[0] = m->layer[1];
        m->layer[1] = last;
    }
}

// Cubes of this size about the middle of the box, with some room around.
static void lay_grid(March *m, Box box, double step) {
    Vec3 size = vec3_sub(box.max, box.min), middle = vec3_lerp(box.min, box.max, 0.5);
    m->step = step;
    m->n[0] = (int)ceil(size.x / step) + 1;
    m->n[1] = (int)ceil(size.y / step) + 1;
    m->n[2] = (int)ceil(size.z / step) + 1;
    m->origin = vec3_sub(middle, vec3_scale(vec3(m->n[0], m->n[1], m->n[2]), step / 2));
    int count = (m->n[0] + 1) * (m->n[1] + 1);
    for (int k = 0; k < 2; k++) m->layer[k] = ARENA_ARRAY(m->arena, Vertex, count);
}

void curved_balls_mesh(const CurvedBall *balls, int count, double threshold, double tolerance, Arena *arena,
                       CurvedMesh *out) {
    March m = {.field = {balls, count, threshold}, .arena = arena, .out = out};
    Box box = curved_field_box(balls, count);
    if (box_is_empty(box)) return;
    Vec3 size = vec3_sub(box.max, box.min);
    double longest = fmax(size.x, fmax(size.y, size.z)), least = longest / CURVED_MOST_CELLS,
           step = longest / LEAST_CELLS;
    for (int i = 0; i < count; i++)
        if (balls[i].weight > 0) step = fmin(step, balls[i].radius / BALL_CELLS);
    for (step = fmax(step, least);; step = fmax(least, step * fmin(0.9, sqrt(AIM * tolerance / m.worst)))) {
        lay_grid(&m, box, step);
        march(&m);
        if (m.worst <= tolerance || step <= least) break;
    }
    out->tolerance = m.worst;
}
