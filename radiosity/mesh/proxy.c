// proxy.c - finds the polygons that are too fine to show differences of light, and makes their stand-ins: edges are collapsed, then
// flat pieces merged.
//
// This method was chosen over vertex clustering on a grid (Rossignac & Borrel 1993) and over elements shared by fine polygons:
// README.md has the figures.
#include "radiosity/mesh/proxy.h"

#include <math.h>

#include "engine/core/arena.h"
#include "engine/core/error.h"
#include "engine/core/heap.h"
#include "engine/core/polygon.h"
#include "engine/core/vec.h"
#include "radiosity/mesh/mesh_places.h"

typedef struct SimplifyTriangle {
    int corner[3];  // in `points`, counter-clockwise from its front
    int tag;        // the material; the border between two tags stays within the tolerance; -1: removed
} SimplifyTriangle;

typedef struct SimplifySurface {
    const Vec3 *points;           // [point_count] each place once
    const unsigned char *locked;  // [point_count] 1: the point must not move
    int point_count;
    SimplifyTriangle *triangles;  // [triangle_count]
    int triangle_count;
} SimplifySurface;

// A merged polygon.
typedef struct ProxyPolygon {
    int *corner;     // [count] in `points`, counter-clockwise
    int count, tag;  // count 0: the polygon became part of another
} ProxyPolygon;

// ---- half-edge collapses, the one of least harm first: a corner moves to the place of a neighbour, so that all corners are
// vertices of the model, inside its hull, and two parallel sheets stay at their distance.
//
// Sources: R. Ronfard & J. Rossignac, Full-Range Approximation of Triangulated Polyhedra, 1996 (the harm is the distance to the
// farthest of the planes that a corner stands for); T. K. Dey, H. Edelsbrunner, S. Guha & D. V. Nekhayev, Topology
// Preserving Edge Contraction, 1999 (the link condition). Quadrics (Garland & Heckbert 1997) are quicker, but do not bound
// the greatest distance.

// The least cosine by which a collapse may turn a triangle: a round leg may become square, but nothing folds.
static const double LEAST_TURNED = 0.35;
// A collapse must not leave a triangle thinner than this, height over longest edge, unless the triangle was even thinner before.
static const double THIN = 0.05;
// Two planes are one if 1 - cosine of their normals is below SAME_WAY and they are at most SAME_PLACE tolerances apart.
static const double SAME_WAY = 1e-4, SAME_PLACE = 0.02;
// Among moves with equal harm, the one along the shorter edge goes first: a metre of edge counts as this many metres of harm.
static const double LENGTH_WEIGHT = 1e-3;
// A corner is not moved where the result would stand for more planes than this: testing all of them takes too long.
enum { MOST_PLANES = 160 };
// Corners with more neighbours than this stay where they are.
enum { MOST_NEIGHBOURS = 64 };

typedef struct List {
    int *item;
    int count, capacity;
} List;

// A possible move of a corner to the place of another.
typedef struct Move {
    double harm;  // metres
    int from, to;
    unsigned stamp;  // Work.stamp of `from` when the harm was measured
} Move;

// Two moves are equal in this order only if they differ in their stamps, so the result does not depend on the order in which moves
// are added.
static bool is_better_move(const void *context, const void *p, const void *q) {
    const Move *a = p, *b = q;
    (void)context;
    if (a->harm != b->harm) return a->harm < b->harm;
    return a->from != b->from ? a->from < b->from : a->to < b->to;
}

typedef struct Work {
    SimplifySurface *s;
    double tolerance;
    Arena arena;
    List *triangles;  // [point_count] the triangles that meet at the point
    List *planes;     // [point_count] the planes that the point stands for
    Plane *plane;     // [plane_count]
    int plane_count, plane_capacity;
    unsigned *stamp;  // [point_count] moves with another stamp are out of date
    int *mark, now;   // [point_count] a point is marked where `mark` equals `now`
    Move *moves;      // a heap: the move of least harm is first
    int move_count, move_capacity;
} Work;

static void push(Arena *arena, List *list, int item) {
    *ARENA_PUSH(arena, list->item, list->count, list->capacity) = item;
}

// ---- triangles

static bool has(const SimplifyTriangle *t, int point) {
    return t->corner[0] == point || t->corner[1] == point || t->corner[2] == point;
}

static Vec3 normal_of(const Vec3 v[3]) { return vec3_cross(vec3_sub(v[1], v[0]), vec3_sub(v[2], v[0])); }

// Height over longest edge.
static double shape_of(const Vec3 v[3]) {
    double longest = 0;
    for (int k = 0; k < 3; k++) {
        Vec3 edge = vec3_sub(v[(k + 1) % 3], v[k]);
        longest = fmax(longest, vec3_dot(edge, edge));
    }
    return longest > 0 ? vec3_length(normal_of(v)) / longest : 0;
}

// Lists and marks the neighbours of corner u, each once; returns how many, MOST_NEIGHBOURS + 1 where there are more than fit.
static int neighbours_of(Work *w, int u, int out[MOST_NEIGHBOURS]) {
    int count = 0;
    w->now++;
    for (int i = 0; i < w->triangles[u].count; i++) {
        const SimplifyTriangle *t = &w->s->triangles[w->triangles[u].item[i]];
        if (t->tag < 0) continue;
        for (int k = 0; k < 3; k++) {
            int v = t->corner[k];
            if (v == u || w->mark[v] == w->now) continue;
            w->mark[v] = w->now;
            if (count == MOST_NEIGHBOURS) return MOST_NEIGHBOURS + 1;
            out[count++] = v;
        }
    }
    return count;
}

// ---- is a collapse allowed?

// Does no remaining triangle turn over or become a needle if corner u moves to v?
static bool keeps_shapes(const Work *w, int u, int v) {
    const Vec3 *points = w->s->points;
    for (int i = 0; i < w->triangles[u].count; i++) {
        const SimplifyTriangle *t = &w->s->triangles[w->triangles[u].item[i]];
        if (t->tag < 0 || has(t, v)) continue;
        Vec3 old[3], new[3];
        for (int k = 0; k < 3; k++) {
            old[k] = points[t->corner[k]];
            new[k] = t->corner[k] == u ? points[v] : old[k];
        }
        Vec3 a = normal_of(old), b = normal_of(new);
        if (vec3_dot(a, b) <= LEAST_TURNED * vec3_length(a) * vec3_length(b)) return false;
        double shape = shape_of(new);
        if (shape < THIN && shape < shape_of(old)) return false;
    }
    return true;
}

// The link condition: each common neighbour of u and v must be the third corner of a triangle on their edge. Otherwise the collapse
// closes a tube or folds two sheets into one.
static bool keeps_topology(Work *w, int u, int v) {
    int around[MOST_NEIGHBOURS], count = neighbours_of(w, v, around), common = 0, opposite = 0;
    if (count > MOST_NEIGHBOURS) return false;
    int of_v = w->now, seen = ++w->now;
    for (int i = 0; i < w->triangles[u].count; i++) {
        const SimplifyTriangle *t = &w->s->triangles[w->triangles[u].item[i]];
        if (t->tag < 0) continue;
        for (int k = 0; k < 3; k++) {
            int x = t->corner[k];
            if (x == u || x == v || w->mark[x] != of_v) continue;
            w->mark[x] = seen;
            common++;
        }
    }
    int counted = ++w->now;
    for (int i = 0; i < w->triangles[u].count; i++) {
        const SimplifyTriangle *t = &w->s->triangles[w->triangles[u].item[i]];
        if (t->tag < 0 || !has(t, v)) continue;
        for (int k = 0; k < 3; k++) {
            int x = t->corner[k];
            if (x == u || x == v || w->mark[x] == counted) continue;
            w->mark[x] = counted;
            opposite++;
        }
    }
    return common == opposite;
}

// Does the collapse leave any of the triangles at u and v?
static bool keeps_body(const Work *w, int u, int v) {
    int left = 0;
    for (int i = 0; i < w->triangles[u].count; i++) {
        const SimplifyTriangle *t = &w->s->triangles[w->triangles[u].item[i]];
        left += t->tag >= 0 && !has(t, v);
    }
    for (int i = 0; i < w->triangles[v].count; i++) {
        const SimplifyTriangle *t = &w->s->triangles[w->triangles[v].item[i]];
        left += t->tag >= 0 && !has(t, u);
    }
    return left > 0;
}

static bool is_allowed(Work *w, int u, int v) {
    return keeps_body(w, u, v) && keeps_topology(w, u, v) && keeps_shapes(w, u, v);
}

// ---- harm

static double harm_of(const Work *w, int u, Vec3 at) {
    double most = 0;
    for (int i = 0; i < w->planes[u].count; i++) {
        double off = fabs(plane_distance(w->plane[w->planes[u].item[i]], at));
        most = off > most ? off : most;
    }
    return most;
}

static void push_move(Work *w, const Move *move) {
    (void)ARENA_PUSH(&w->arena, w->moves, w->move_count, w->move_capacity);
    const Heap heap = {.items = w->moves, .size = sizeof *w->moves, .before = is_better_move};
    heap_rise(&heap, w->move_count - 1, move);
}

static Move pop_move(Work *w) {
    const Heap heap = {.items = w->moves, .size = sizeof *w->moves, .before = is_better_move};
    Move first = w->moves[0];
    heap_drop_first(&heap, w->move_count--);
    return first;
}

// Puts the best allowed move of corner u on the heap.
static void consider(Work *w, int u) {
    int around[MOST_NEIGHBOURS], count;
    Move ways[MOST_NEIGHBOURS];
    int way_count = 0;
    w->stamp[u]++;
    if (w->s->locked[u] || (count = neighbours_of(w, u, around)) > MOST_NEIGHBOURS) return;
    for (int i = 0; i < count; i++) {
        Vec3 at = w->s->points[around[i]];
        double harm = harm_of(w, u, at);
        if (harm > w->tolerance) continue;
        harm += LENGTH_WEIGHT * vec3_length(vec3_sub(at, w->s->points[u]));
        Move c = {harm, u, around[i], w->stamp[u]};
        int k = way_count++;
        for (; k > 0 && is_better_move(NULL, &c, &ways[k - 1]); k--) ways[k] = ways[k - 1];
        ways[k] = c;
    }
    for (int i = 0; i < way_count; i++) {
        if (!is_allowed(w, u, ways[i].to)) continue;
        push_move(w, &ways[i]);
        return;
    }
}

// ---- collapses

static bool is_one_plane(const Work *w, Plane a, Plane b, Vec3 at) {
    double cosine = vec3_dot(a.n, b.n);
    return fabs(cosine) > 1 - SAME_WAY &&
           fabs(plane_distance(a, at) - copysign(1, cosine) * plane_distance(b, at)) <=
               SAME_PLACE * w->tolerance;
}

static void add_plane(Work *w, int point, int plane) {
    List *list = &w->planes[point];
    for (int i = 0; i < list->count; i++)
        if (is_one_plane(w, w->plane[list->item[i]], w->plane[plane], w->s->points[point])) return;
    push(&w->arena, list, plane);
}

static void collapse(Work *w, int u, int v) {
    for (int i = 0; i < w->triangles[u].count; i++) {
        int index = w->triangles[u].item[i];
        SimplifyTriangle *t = &w->s->triangles[index];
        if (t->tag < 0) continue;
        if (has(t, v)) {
            t->tag = -1;
            continue;
        }
        for (int k = 0; k < 3; k++) t->corner[k] = t->corner[k] == u ? v : t->corner[k];
        push(&w->arena, &w->triangles[v], index);
    }
    List *list = &w->triangles[v];
    int kept = 0;
    for (int i = 0; i < list->count; i++)
        if (w->s->triangles[list->item[i]].tag >= 0) list->item[kept++] = list->item[i];
    list->count = kept;
    for (int i = 0; i < w->planes[u].count; i++) add_plane(w, v, w->planes[u].item[i]);
    w->triangles[u] = w->planes[u] = (List){0};
    w->stamp[u]++;
}

// ---- the beginning

static int new_plane(Work *w, Vec3 n, Vec3 at) {
    *ARENA_PUSH(&w->arena, w->plane, w->plane_count, w->plane_capacity) = (Plane){n, vec3_dot(n, at)};
    return w->plane_count - 1;
}

// The third corner of the triangles with this tag on the edge between a and b; -1: there is none; -2: there are several.
static int across(const Work *w, int a, int b, int tag) {
    int found = -1;
    for (int i = 0; i < w->triangles[a].count; i++) {
        const SimplifyTriangle *t = &w->s->triangles[w->triangles[a].item[i]];
        if (t->tag != tag || !has(t, b)) continue;
        for (int k = 0; k < 3; k++) {
            int x = t->corner[k];
            if (x == a || x == b || x == found) continue;
            found = found == -1 ? x : -2;
        }
    }
    return found;
}

// Where a sheet or a material ends at an edge, adds a plane that stands on this edge, so that the border keeps its outline.
static void add_borders(Work *w, int triangle) {
    const SimplifyTriangle *t = &w->s->triangles[triangle];
    Vec3 v[3];
    for (int k = 0; k < 3; k++) v[k] = w->s->points[t->corner[k]];
    Vec3 n = vec3_normalize(normal_of(v));
    for (int k = 0; k < 3; k++) {
        int a = t->corner[k], b = t->corner[(k + 1) % 3];
        if (across(w, a, b, t->tag) == -2) continue;
        int plane = new_plane(w, vec3_normalize(vec3_cross(vec3_sub(v[(k + 1) % 3], v[k]), n)), v[k]);
        add_plane(w, a, plane);
        add_plane(w, b, plane);
    }
}

static void start_moves(Work *w) {
    SimplifySurface *s = w->s;
    w->triangles = ARENA_ARRAY(&w->arena, List, s->point_count);
    w->planes = ARENA_ARRAY(&w->arena, List, s->point_count);
    w->stamp = ARENA_ARRAY(&w->arena, unsigned, s->point_count);
    w->mark = ARENA_ARRAY(&w->arena, int, s->point_count);
    for (int i = 0; i < s->triangle_count; i++) {
        SimplifyTriangle *t = &s->triangles[i];
        Vec3 v[3];
        for (int k = 0; k < 3; k++) v[k] = s->points[t->corner[k]];
        Vec3 n = normal_of(v);
        if (!(vec3_length(n) > 0)) {
            t->tag = -1;
            continue;
        }
        int plane = new_plane(w, vec3_normalize(n), v[0]);
        for (int k = 0; k < 3; k++) {
            push(&w->arena, &w->triangles[t->corner[k]], i);
            add_plane(w, t->corner[k], plane);
        }
    }
    for (int i = 0; i < s->triangle_count; i++)
        if (s->triangles[i].tag >= 0) add_borders(w, i);
    for (int p = 0; p < s->point_count; p++) consider(w, p);
}

// Moves corners of triangles to the places of other corners, and drops triangles without area. A closed surface stays closed, no
// triangle is turned over, and no corner is farther than the tolerance, metres, from the planes of the triangles that it stands
// for. Moves the remaining triangles to the front; returns how many. The same input gives the same result.
static int simplify(SimplifySurface *surface, double tolerance) {
    Work w = {.s = surface, .tolerance = tolerance};
    start_moves(&w);
    while (w.move_count > 0) {
        Move c = pop_move(&w);
        if (c.stamp != w.stamp[c.from]) continue;
        if (!is_allowed(&w, c.from, c.to)) {
            consider(&w, c.from);
            continue;
        }
        if (w.planes[c.from].count + w.planes[c.to].count > MOST_PLANES) continue;
        collapse(&w, c.from, c.to);
        int around[MOST_NEIGHBOURS], count = neighbours_of(&w, c.to, around);
        consider(&w, c.to);
        for (int i = 0; i < count && count <= MOST_NEIGHBOURS; i++) consider(&w, around[i]);
    }
    int kept = 0;
    for (int i = 0; i < surface->triangle_count; i++)
        if (surface->triangles[i].tag >= 0) surface->triangles[kept++] = surface->triangles[i];
    arena_free(&w.arena);
    return kept;
}

// ---- merging: polygons grow over their edges while they stay flat and convex, so that views have one polygon for a panel instead
// of dozens.

// How far a merged polygon may bend, metres: half as far as polygons of buildings may.
static const double FLAT = 0.5 * MAPS_PLANARITY;
// Two polygons are merged only if the cosine of their normals is at least this; a larger angle is a crease.
static const double SAME_PLANE = 0.999;

// Directed edges by their ends, in a table with open addressing.
typedef struct Edge {
    int from, to, polygon;  // polygon -1: nothing is here
} Edge;

typedef struct Merge {
    const Vec3 *points;
    ProxyPolygon *polygons;
    int *became;  // [count] the polygon that this one was merged into, itself if it was not merged
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

// Lists the corners of a, from the end of the edge round to its beginning, then the other corners of b; returns how many.
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

// Merges polygon a with its neighbour beyond the edge from -> to, if the result is flat, convex and small enough.
static bool try_merge(Merge *m, int a, int from, int to, Arena *arena) {
    const Edge *beyond = edge_at(m, to, from);
    if (beyond->polygon < 0) return false;
    int b = polygon_of(m, beyond->polygon);
    ProxyPolygon *p = &m->polygons[a], *q = &m->polygons[b];
    int corner[2 * PROXY_CORNERS];
    Vec3 v[2 * PROXY_CORNERS];
    if (a == b || p->tag != q->tag || p->count + q->count - 2 > PROXY_CORNERS) return false;
    if (vec3_dot(plane_of(m, p, v).n, plane_of(m, q, v).n) < SAME_PLANE) return false;
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

// Merges triangles [count] into polygons [count], in the arena; an entry with count 0 was merged into another.
static ProxyPolygon *proxy_merge(const Vec3 *points, const SimplifyTriangle *triangles, int count,
                                 Arena *arena) {
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
            // Where several triangles have the same directed edge, the first one counts.
            if (e->polygon < 0) *e = (Edge){t->corner[k], t->corner[(k + 1) % 3], i};
        }
    }
    for (int i = 0; i < count; i++)
        if (m.polygons[i].count > 0) grow_region(&m, i, arena);
    arena_free(&scratch);
    return m.polygons;
}

// A polygon is fine if its width, area over longest edge, is below this, metres: half the edge of the smallest elements. Elements do
// not resolve light across such a polygon.
static const double NARROW = 0.03;
// An object with fewer fine polygons than this has no stand-in: the views of a room have hundreds of polygons anyway.
enum { FEWEST = 64 };
// A stand-in with more polygons than this share of the polygons that it replaces is not used: it would cost accuracy and save little.
static const double WORTH = 0.7;

typedef struct Finder {
    const CellGraph *graph;
    Proxies *out;
    Arena *arena;
    int polygon_capacity, vertex_capacity;
} Finder;

static bool polygon_emits(const CellGraph *graph, int polygon) {
    const Material *m = &graph->building->materials[graph->polygons[polygon].material];
    return m->emission.r + m->emission.g + m->emission.b > 0 || m->full.r + m->full.g + m->full.b > 0;
}

static bool is_fine(const Finder *f, int polygon) {
    const Polygon *p = &f->graph->polygons[polygon];
    const Vec3 *v = f->graph->vertices + p->first_vertex;
    double longest = 0;
    if (vis_is_glass(f->graph, polygon) || polygon_emits(f->graph, polygon)) return false;
    for (int i = 0; i < p->vertex_count; i++)
        longest = fmax(longest, vec3_length(vec3_sub(v[(i + 1) % p->vertex_count], v[i])));
    return polygon_area(v, p->vertex_count) < NARROW * longest;
}

static bool may_stand_in(const Object *object) {
    return object->kind != OBJECT_SURFACE && object->leaf < 0 && !object->plug;
}

static int count_fine(const Finder *f, const Object *object) {
    int count = 0;
    for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++)
        count += is_fine(f, p);
    return count;
}

// ---- one object

// The fine polygons of an object as triangles that share corners. Corners shared with its other polygons are locked.
typedef struct Model {
    Places places;
    SimplifyTriangle *triangles;
    unsigned char *locked;
    int triangle_count, triangle_capacity, locked_capacity;
} Model;

static int vertex_place(Model *m, Vec3 v, Arena *arena) {
    int before = m->places.count, place = places_add(&m->places, v);
    if (place == before) *ARENA_PUSH(arena, m->locked, before, m->locked_capacity) = 0;
    return place;
}

static void add_triangles(Model *m, const Vec3 *v, int count, int tag, Arena *arena) {
    int *triangle = ARENA_ARRAY(arena, int, 3 * count);
    polygon_triangulate(v, count, triangle);
    for (int i = 0; i < count - 2; i++) {
        SimplifyTriangle t = {.tag = tag};
        for (int k = 0; k < 3; k++) t.corner[k] = vertex_place(m, v[triangle[3 * i + k]], arena);
        if (t.corner[0] == t.corner[1] || t.corner[1] == t.corner[2] || t.corner[2] == t.corner[0]) continue;
        *ARENA_PUSH(arena, m->triangles, m->triangle_count, m->triangle_capacity) = t;
    }
}

// Polygons that are not fine lock the corners that they share with fine ones.
static Model model_of(const Finder *f, const Object *object, Arena *arena) {
    Model m = {0};
    places_start(&m.places, arena);
    for (int pass = 0; pass < 2; pass++) {
        for (int i = object->first_polygon; i < object->first_polygon + object->polygon_count; i++) {
            const Polygon *p = &f->graph->polygons[i];
            const Vec3 *v = f->graph->vertices + p->first_vertex;
            bool fine = is_fine(f, i);
            if (pass == 0 && fine) add_triangles(&m, v, p->vertex_count, p->material, arena);
            for (int k = 0; pass == 1 && !fine && k < p->vertex_count; k++)
                m.locked[vertex_place(&m, v[k], arena)] = 1;
        }
    }
    return m;
}

static void add_proxy_polygon(Finder *f, const Model *m, const ProxyPolygon *p) {
    Proxies *out = f->out;
    *ARENA_PUSH(f->arena, out->polygons, out->polygon_count, f->polygon_capacity) =
        (Polygon){out->vertex_count, p->count, p->tag, 0};
    for (int k = 0; k < p->count; k++)
        *ARENA_PUSH(f->arena, out->vertices, out->vertex_count, f->vertex_capacity) =
            m->places.points[p->corner[k]];
}

static void find_of_object(Finder *f, int index) {
    const Object *object = &f->graph->objects[index];
    int fine = may_stand_in(object) ? count_fine(f, object) : 0, merged = 0;
    if (fine < FEWEST) return;
    Arena scratch = {0};
    Model m = model_of(f, object, &scratch);
    SimplifySurface surface = {m.places.points, m.locked, m.places.count, m.triangles, m.triangle_count};
    int triangles = simplify(&surface, f->out->tolerance);
    const ProxyPolygon *polygons = proxy_merge(m.places.points, m.triangles, triangles, &scratch);
    for (int i = 0; i < triangles; i++) merged += polygons[i].count > 0;
    if (merged <= WORTH * fine) {
        for (int i = 0; i < triangles; i++)
            if (polygons[i].count > 0) add_proxy_polygon(f, &m, &polygons[i]);
        for (int p = object->first_polygon; p < object->first_polygon + object->polygon_count; p++)
            f->out->replaced[p] = is_fine(f, p);
        f->out->object_count++;
        f->out->replaced_count += fine;
    }
    arena_free(&scratch);
}

const Proxies *proxies_find(const CellGraph *graph, double tolerance, Arena *arena) {
    if (!(tolerance > 0)) return NULL;
    Proxies *out = ARENA_ARRAY(arena, Proxies, 1);
    Finder f = {graph, out, arena, 0, 0};
    // Rounded as .rad files store it.
    *out = (Proxies){.tolerance = nearbyint(tolerance / PROXY_STEP) * PROXY_STEP,
                     .first = ARENA_ARRAY(arena, int, graph->object_count + 1),
                     .replaced = ARENA_ARRAY(arena, bool, graph->polygon_count + 1)};
    for (int o = 0; o < graph->object_count; o++) {
        find_of_object(&f, o);
        out->first[o + 1] = out->polygon_count;
    }
    if (out->object_count == 0) return NULL;
    vis_register(graph, out->polygons, out->vertices, out->first, arena, &out->graph);
    return out;
}
