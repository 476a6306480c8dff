// simplify.c - half-edge collapses, the least harm first: a corner moves to a neighbour's place, so that what is left lies on the model
// and within its hull, and two panes stay as far apart as they are.
//
// Sources: R. Ronfard & J. Rossignac, Full-Range Approximation of Triangulated Polyhedra, 1996 (the harm is the distance to the
// farthest of the planes that a corner stands for); T. K. Dey, H. Edelsbrunner, S. Guha & D. V. Nekhayev, Topology
// Preserving Edge Contraction, 1999 (the link condition). Quadrics (Garland & Heckbert 1997) are quicker, but say nothing
// of the greatest distance.
#include "radiosity/mesh/simplify.h"

#include <math.h>

#include "engine/core/heap.h"

// How far a collapse may turn a triangle, as a cosine: a round leg may become square, but nothing folds.
static const double LEAST_TURNED = 0.35;
// A collapse does not leave a triangle thinner than this, height over longest edge, unless it made it thicker.
static const double THIN = 0.05;
// Planes are one where their normals are this near, 1 - cosine, and they are this share of the tolerance apart.
static const double SAME_WAY = 1e-4, SAME_PLACE = 0.02;
// Among equal harms the shorter edge goes first: a metre of edge counts as so many of harm.
static const double LENGTH_WEIGHT = 1e-3;
// A corner that would stand for more planes stays: the time it takes to ask them all.
enum { MOST_PLANES = 160 };
// Neighbours that a corner may move to, the best first, that are tried; corners with more neighbours stay.
enum { MOST_NEIGHBOURS = 64 };

typedef struct List {
    int *item;
    int count, capacity;
} List;

// A corner may move to the place of another.
typedef struct Move {
    double harm;  // metres
    int from, to;
    unsigned stamp;  // of `from`, when the harm was measured
} Move;

// The order has no equals but moves of other stamps: results do not depend on the order in which moves came.
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
    List *triangles;  // [point_count] that meet there
    List *planes;     // [point_count] that it stands for
    Plane *plane;     // all
    int plane_count, plane_capacity;
    unsigned *stamp;  // [point_count] candidates of other stamps are of the past
    int *mark, now;   // [point_count]
    Move *moves;      // a heap: the move that does least harm is first
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

// The corners of u's neighbours, each once, by the mark.
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

// No triangle that is left turns over or becomes a needle.
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

// A neighbour of both must be the third corner of a triangle on their edge: otherwise a tube closes or two sheets fold
// into one.
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

// Is something left of what hangs together here?
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

// The best that u can do, onto the heap.
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

// The third corner of all triangles on the edge a -> b with this tag; -1: none; -2: several.
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

// Where a sheet or a colour ends a plane stands on the edge: it keeps its outline.
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

int simplify(SimplifySurface *surface, double tolerance) {
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
