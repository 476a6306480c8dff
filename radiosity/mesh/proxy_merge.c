// proxy_merge.c - polygons grow over their edges while they stay flat and convex: a panel is one polygon, not dozens, to whoever looks.
#include "radiosity/mesh/proxy_merge.h"

#include "engine/core/polygon.h"
#include "radiosity/mesh/proxy.h"

// How far a merged polygon may bend, metres: half of what polygons of buildings may.
static const double FLAT = 0.5 * MAPS_PLANARITY;
// Polygons turn by less than this where they are one, as a cosine: a thumb's breadth of a bend is a crease.
static const double SAME_WAY = 0.999;

// Directed edges by their ends, in a table with open addressing.
typedef struct Edge {
    int from, to, polygon;  // polygon -1: nothing is here
} Edge;

typedef struct Merge {
    const Vec3 *points;
    ProxyPolygon *polygons;
    int *became;  // [count] the polygon it is part of
    Edge *edges;
    unsigned edge_count;  // a power of two
} Merge;

static Edge *edge_at(const Merge *m, int from, int to) {
    unsigned h = (unsigned)from * 0x9e3779b1u ^ (unsigned)to * 0x85ebca77u;
    h ^= h >> 15;
    h *= 0xc2b2ae3du;
    h ^= h >> 13;
    for (unsigned at = h & (m->edge_count - 1);; at = (at + 1) & (m->edge_count - 1)) {
        Edge *e = &m->edges[at];
        if (e->polygon < 0 || (e->from == from && e->to == to)) return e;
    }
}

static int polygon_of(const Merge *m, int polygon) {
    while (m->became[polygon] != polygon) polygon = m->became[polygon];
    return polygon;
}

static Plane plane_of(const Merge *m, const ProxyPolygon *p, Vec3 *v) {
    for (int i = 0; i < p->count; i++) v[i] = m->points[p->corner[i]];
    return plane_of_polygon(v, p->count);
}

// Corners of a, from the end of the edge round to its beginning, then those of b between: returns how many.
static int join_corners(const ProxyPolygon *a, const ProxyPolygon *b, int from, int to, int *out) {
    int at_a = 0, at_b = 0, count = 0;
    while (a->corner[at_a] != to) at_a++;
    while (b->corner[at_b] != from) at_b++;
    for (int i = 0; i < a->count; i++) out[count++] = a->corner[(at_a + i) % a->count];
    for (int i = 1; i + 1 < b->count; i++) out[count++] = b->corner[(at_b + i) % b->count];
    return count;
}

static bool is_simple(const int *corner, int count) {
    for (int i = 0; i < count; i++)
        for (int k = 0; k < i; k++)
            if (corner[i] == corner[k]) return false;
    return true;
}

// Over the edge from -> to of polygon a.
static bool try_merge(Merge *m, int a, int from, int to, Arena *arena) {
    const Edge *beyond = edge_at(m, to, from);
    if (beyond->polygon < 0) return false;
    int b = polygon_of(m, beyond->polygon);
    ProxyPolygon *p = &m->polygons[a], *q = &m->polygons[b];
    int corner[2 * PROXY_CORNERS];
    Vec3 v[2 * PROXY_CORNERS];
    if (a == b || p->tag != q->tag || p->count + q->count - 2 > PROXY_CORNERS) return false;
    if (vec3_dot(plane_of(m, p, v).n, plane_of(m, q, v).n) < SAME_WAY) return false;
    ProxyPolygon both = {corner, join_corners(p, q, from, to, corner), p->tag};
    if (!is_simple(corner, both.count)) return false;
    Plane plane = plane_of(m, &both, v);
    if (polygon_bend(v, both.count, plane) > FLAT || !polygon_is_convex(v, both.count, plane.n)) return false;
    p->corner = memcpy(ARENA_ARRAY(arena, int, both.count), corner, (size_t)both.count * sizeof *corner);
    p->count = both.count;
    q->count = 0;
    m->became[b] = a;
    return true;
}

static void grow_region(Merge *m, int polygon, Arena *arena) {
    for (bool grown = true; grown;) {
        grown = false;
        const ProxyPolygon *p = &m->polygons[polygon];
        for (int i = 0; i < p->count && !grown; i++)
            grown = try_merge(m, polygon, p->corner[i], p->corner[(i + 1) % p->count], arena);
    }
}

ProxyPolygon *proxy_merge(const Vec3 *points, const SimplifyTriangle *triangles, int count, Arena *arena) {
    Arena scratch = {0};
    Merge m = {points, ARENA_ARRAY(arena, ProxyPolygon, count), ARENA_ARRAY(&scratch, int, count), NULL, 16};
    while (m.edge_count < 8u * (unsigned)count) m.edge_count *= 2;
    m.edges = ARENA_ARRAY(&scratch, Edge, m.edge_count);
    for (unsigned i = 0; i < m.edge_count; i++) m.edges[i].polygon = -1;
    for (int i = 0; i < count; i++) {
        const SimplifyTriangle *t = &triangles[i];
        m.polygons[i] = (ProxyPolygon){ARENA_ARRAY(arena, int, 3), 3, t->tag};
        m.became[i] = i;
        memcpy(m.polygons[i].corner, t->corner, sizeof t->corner);
        for (int k = 0; k < 3; k++) {
            Edge *e = edge_at(&m, t->corner[k], t->corner[(k + 1) % 3]);
            // Among sheets in one place the first counts.
            if (e->polygon < 0) *e = (Edge){t->corner[k], t->corner[(k + 1) % 3], i};
        }
    }
    for (int i = 0; i < count; i++)
        if (m.polygons[i].count > 0) grow_region(&m, i, arena);
    arena_free(&scratch);
    return m.polygons;
}
