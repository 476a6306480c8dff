// hidden_excuse.c - distances from projected edges and lines of intersection, in long doubles.
#include "tests/support/oracles/hidden_excuse.h"

#include <criterion/criterion.h>

typedef long double Real;
typedef struct Point {
    Real x, y, z;
} Point;

struct HiddenJudge {
    const Scene *scene;
    Facets facets;
};

HiddenJudge *hidden_judge_new(const Scene *scene, Arena *arena) {
    HiddenJudge *judge = ARENA_ARRAY(arena, HiddenJudge, 1);
    Error error;
    judge->scene = scene;
    cr_assert(facets_new(scene, arena, &judge->facets, &error), "%s", error.text);
    return judge;
}

static Real dot(Vec3 a, Point b) { return (Real)a.x * b.x + (Real)a.y * b.y + (Real)a.z * b.z; }
static Point cross(Point a, Point b) {
    return (Point){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// (X, Y, Z) of a point: at pixel (X / Z, Y / Z), Z away.
static Point place(const Camera *c, Vec3 at) {
    Point d = {(Real)at.x - (Real)c->eye.x, (Real)at.y - (Real)c->eye.y, (Real)at.z - (Real)c->eye.z};
    Real z = dot(c->forward, d), x = dot(c->right, d) / (Real)c->tan_x, y = dot(c->up, d) / (Real)c->tan_y;
    return (Point){(z + x) * c->width / 2, (z - y) * c->height / 2, z};
}

typedef struct Linear {
    Real a, b, c;
} Linear;

static Real at(Linear l, Real x, Real y) { return l.a * x + l.b * y + l.c; }
static Real pixels_from(Linear l, Real x, Real y) {
    Real slope = hypotl(l.a, l.b);
    return slope > 0 ? fabsl(at(l, x, y)) / slope : INFINITY;
}

// 1/z of a facet's plane over the picture; false: it is seen edge-on, or too nearly.
static bool depth_of(const HiddenJudge *judge, const Camera *c, const Facet *f, HiddenSlack slack,
                     Linear *out) {
    const Vec3 *v = judge->facets.corners + f->first;
    Point sum = {0, 0, 0}, first = place(c, v[0]);
    for (int i = 1; i + 1 < f->count; i++) {
        Point p = place(c, v[i]), q = place(c, v[i + 1]);
        Point u = {p.x - first.x, p.y - first.y, p.z - first.z},
              w = {q.x - first.x, q.y - first.y, q.z - first.z};
        Point n = cross(u, w);
        sum = (Point){sum.x + n.x, sum.y + n.y, sum.z + n.z};
    }
    Real height = sum.x * first.x + sum.y * first.y + sum.z * first.z;
    if (height == 0) return false;
    *out = (Linear){sum.x / height, sum.y / height, sum.z / height};
    Real real_height = fabsl((Real)f->n.x * ((Real)f->centre.x - (Real)c->eye.x) +
                             (Real)f->n.y * ((Real)f->centre.y - (Real)c->eye.y) +
                             (Real)f->n.z * ((Real)f->centre.z - (Real)c->eye.z));
    return real_height > (Real)slack.edge_on + (Real)judge->facets.rounding;
}

// The least distance of the sample from an edge's line, pixels, where that is next to the edge itself.
static Real edge_distance(const HiddenJudge *judge, const Camera *c, const Facet *f, Real x, Real y) {
    const Vec3 *v = judge->facets.corners + f->first;
    Real least = INFINITY;
    for (int i = 0; i < f->count; i++) {
        Point line = cross(place(c, v[i]), place(c, v[(i + 1) % f->count]));
        least = fminl(least, pixels_from((Linear){line.x, line.y, line.z}, x, y));
    }
    return least;
}

static bool same_corners(const HiddenJudge *judge, const Facet *a, const Facet *b) {
    if (a->count != b->count) return false;
    return memcmp(judge->facets.corners + a->first, judge->facets.corners + b->first,
                  sizeof(Vec3) * (size_t)a->count) == 0;
}

static HiddenExcuse excuse_pair(const HiddenJudge *judge, const Camera *c, Real x, Real y, const Facet *a,
                                const Facet *b, HiddenSlack slack) {
    Linear p, q;
    if (slack.order && same_corners(judge, a, b)) return EXCUSE_NONE;
    if (!depth_of(judge, c, a, slack, &p) || !depth_of(judge, c, b, slack, &q)) return EXCUSE_EDGE;
    Real u = at(p, x, y), w = at(q, x, y);
    if (fabsl(u - w) <= (Real)slack.depth * fmaxl(fabsl(u), fabsl(w))) return EXCUSE_TIE;
    Linear difference = {p.a - q.a, p.b - q.b, p.c - q.c};
    return pixels_from(difference, x, y) <= (Real)slack.pixels ? EXCUSE_CROSSING : EXCUSE_NONE;
}

HiddenExcuse hidden_excuse(const HiddenJudge *judge, const Camera *c, int i, int j, int a, int b,
                           HiddenSlack slack) {
    Real x = i + 0.5L, y = j + 0.5L;
    for (int k = 0; k < judge->facets.count; k++) {
        const Facet *f = &judge->facets.facets[k];
        if (f->polygon != a && f->polygon != b) continue;
        Linear depth;
        if (!depth_of(judge, c, f, slack, &depth) || edge_distance(judge, c, f, x, y) <= (Real)slack.pixels)
            return EXCUSE_EDGE;
        for (int l = 0; f->polygon == a && l < judge->facets.count; l++) {
            const Facet *g = &judge->facets.facets[l];
            HiddenExcuse excuse = g->polygon == b ? excuse_pair(judge, c, x, y, f, g, slack) : EXCUSE_NONE;
            if (excuse != EXCUSE_NONE) return excuse;
        }
    }
    return EXCUSE_NONE;
}

double hidden_height(const HiddenJudge *judge, const Camera *camera, int polygon) {
    const Polygon *p = &judge->scene->polygons[polygon];
    const Vec3 *v = judge->scene->vertices + p->first_vertex;
    return fabs(vec3_dot(plane_of_polygon(v, p->vertex_count).n, vec3_sub(v[0], camera->eye)));
}
