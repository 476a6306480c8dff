// convex_sweep.c - triangles of a plan polygon with very many holes, in n log n.
//
// Source: the plane sweep of S. Hertel & K. Mehlhorn, Fast triangulation of simple polygons, 1983. A line sweeps from left to right.
// Each stretch of it that lies inside keeps the chain of vertices, from its lower edge to its upper one, up to which triangles are
// made; no corner of the chain can see past its neighbours, so that a new vertex makes triangles at the chain's ends only. Signs are
// exact. Rings may touch at vertices, not within edges.
#include <stdlib.h>

#include "visibility/cells/convex.h"

// A vertex of a chain; `up` and `down` are nodes, -1 at the ends.
typedef struct Link {
    int point, up, down;
} Link;

typedef struct Chain {
    int bottom, top, last;  // links; `last`: the one added last, the rightmost
} Chain;

// An edge from its left end to its right one.
typedef struct SweepEdge {
    int left, right;  // points
    bool inside;      // the polygon lies above it
    Chain chain;      // of the stretch above it, where that is inside
} SweepEdge;

typedef struct Sweep {
    const Vec2 *at;    // [point] whole millimetres
    SweepEdge *edges;  // by left end, then from below
    int *active;       // edges that the line crosses, from below
    int active_count;
    Link *links;
    int link_count;
    int *triangles;  // three points each, counter-clockwise
    int triangle_count;
} Sweep;

static int turn_of_points(const Sweep *s, int a, int b, int c) {
    return orient2d(s->at[a], s->at[b], s->at[c]);
}

static int compare(Vec2 a, Vec2 b) {
    if (a.x != b.x) return a.x < b.x ? -1 : 1;
    return (a.y > b.y) - (a.y < b.y);
}

static int by_left(const void *p, const void *q, void *sweep) {
    const Sweep *s = sweep;
    const SweepEdge *a = p, *b = q;
    int order = compare(s->at[a->left], s->at[b->left]);
    return order ? order : -turn_of_points(s, a->left, a->right, b->right);
}

static int new_link(Sweep *s, int point) {
    s->links[s->link_count] = (Link){point, -1, -1};
    return s->link_count++;
}

static Chain new_chain(Sweep *s, int point) {
    int link = new_link(s, point);
    return (Chain){link, link, link};
}

static void add_triangle(Sweep *s, int a, int b, int c) {
    int *t = s->triangles + 3 * (size_t)s->triangle_count++;
    t[0] = a;
    t[1] = b;
    t[2] = c;
}

// The chain goes on to a point on its upper edge.
static void add_above(Sweep *s, Chain *chain, int point) {
    int top = chain->top;
    for (int below; (below = s->links[top].down) >= 0; top = below) {
        int a = s->links[below].point, b = s->links[top].point;
        if (turn_of_points(s, a, b, point) >= 0) break;
        add_triangle(s, a, point, b);
    }
    int link = new_link(s, point);
    s->links[link].down = top;
    s->links[top].up = link;
    chain->top = chain->last = link;
}

static void add_below(Sweep *s, Chain *chain, int point) {
    int bottom = chain->bottom;
    for (int above; (above = s->links[bottom].up) >= 0; bottom = above) {
        int a = s->links[bottom].point, b = s->links[above].point;
        if (turn_of_points(s, a, b, point) >= 0) break;
        add_triangle(s, a, point, b);
    }
    int link = new_link(s, point);
    s->links[link].up = bottom;
    s->links[bottom].down = link;
    chain->bottom = chain->last = link;
}

// A point amid a stretch parts its chain at the rightmost vertex, which it sees.
static Chain part(Sweep *s, Chain *chain, int point) {
    int at = chain->last, twin = new_link(s, s->links[at].point);
    Chain above = {twin, at == chain->top ? twin : chain->top, twin};
    s->links[twin].up = s->links[at].up;
    if (s->links[twin].up >= 0) s->links[s->links[twin].up].down = twin;
    s->links[at].up = -1;
    chain->top = at;
    add_above(s, chain, point);
    add_below(s, &above, point);
    return above;
}

// The point at the end of all edges between two stretches makes one chain of theirs.
static void join_chains(Sweep *s, Chain *below, const Chain *above) {
    int twin = above->bottom, next = s->links[twin].up;
    s->links[below->top].up = next;
    if (next >= 0) s->links[next].down = below->top;
    below->last = below->top;
    if (above->top != twin) below->top = above->top;
}

// How many of the active edges lie below the point, or, `through`, do not lie above it.
static int edges_below(const Sweep *s, int point, bool through) {
    int low = 0, high = s->active_count;
    while (low < high) {
        int middle = (low + high) / 2;
        const SweepEdge *e = &s->edges[s->active[middle]];
        int side = turn_of_points(s, e->left, e->right, point);
        if (side > 0 || (through && side == 0))
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

// Takes the edges that end at `point` from the line and puts edges first .. end - 1, which start there, in their place. False where
// the rings are no polygon.
static bool pass(Sweep *s, int point, int first, int end) {
    int low = edges_below(s, point, false), high = edges_below(s, point, true), starts = end - first;
    SweepEdge *under = low > 0 ? &s->edges[s->active[low - 1]] : NULL, *over = NULL;
    for (int i = low; i < high; i++) {
        SweepEdge *e = &s->edges[s->active[i]];
        if (compare(s->at[e->right], s->at[point]) != 0) return false;
        if (i + 1 < high && e->inside) add_above(s, &e->chain, point);
        over = e;
    }
    Chain above = {-1, -1, -1};
    bool below_inside = under && under->inside, above_inside = over ? over->inside : below_inside;
    if (below_inside && !over)
        above = part(s, &under->chain, point);
    else if (below_inside)
        add_above(s, &under->chain, point);
    if (over && above_inside) {
        add_below(s, &over->chain, point);
        above = over->chain;
    }
    if (starts == 0 && above_inside != below_inside) return false;
    if (starts == 0 && below_inside) join_chains(s, &under->chain, &above);
    bool inside = below_inside;
    for (int i = first; i < end; i++) {
        SweepEdge *e = &s->edges[i];
        if (e->inside == inside) return false;
        inside = e->inside;
        if (inside) e->chain = i + 1 < end ? new_chain(s, point) : above;
    }
    if (inside != above_inside) return false;
    memmove(s->active + low + starts, s->active + high, (size_t)(s->active_count - high) * sizeof *s->active);
    for (int i = 0; i < starts; i++) s->active[low + i] = first + i;
    s->active_count += starts - (high - low);
    return true;
}

static int by_sweep_order(const void *p, const void *q, void *sweep) {
    const Sweep *s = sweep;
    return compare(s->at[*(const int *)p], s->at[*(const int *)q]);
}

int convex_sweep(const Vec2 *at, const int (*edges)[2], int count, Arena *arena, int **triangles) {
    Sweep s = {.at = at,
               .edges = ARENA_ARRAY(arena, SweepEdge, count + 1),
               .active = ARENA_ARRAY(arena, int, count + 1),
               .links = ARENA_ARRAY(arena, Link, 6 * (size_t)count + 8),
               .triangles = ARENA_ARRAY(arena, int, 6 * (size_t)count + 6)};
    int *places = ARENA_ARRAY(arena, int, count + 1);
    for (int i = 0; i < count; i++) {
        int a = edges[i][0], b = edges[i][1];
        bool right = compare(at[a], at[b]) < 0;
        s.edges[i] = (SweepEdge){.left = right ? a : b, .right = right ? b : a, .inside = right};
        places[i] = a;
    }
    qsort_r(s.edges, (size_t)count, sizeof *s.edges, by_left, &s);
    qsort_r(places, (size_t)count, sizeof *places, by_sweep_order, &s);
    bool good = true;
    for (int i = 0, first = 0, end; i < count && good; i++) {
        if (i > 0 && by_sweep_order(&places[i - 1], &places[i], &s) == 0) continue;
        for (end = first; end < count && compare(at[s.edges[end].left], at[places[i]]) == 0;) end++;
        good = pass(&s, places[i], first, end);
        first = end;
    }
    *triangles = s.triangles;
    return good && s.active_count == 0 ? s.triangle_count : -1;
}
