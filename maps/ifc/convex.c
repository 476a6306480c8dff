// convex.c - a polygon with holes as convex polygons: holes are joined to the outline by bridges, ears are cut off (G. H. Meisters 1975),
// and diagonals are removed where both ends stay convex (S. Hertel & K. Mehlhorn 1983), which gives at most four times the fewest pieces.
#include "maps/ifc/shape.h"

#include <stdlib.h>

// Corners of one polygon, and comparisons of corners with ears: beyond, the polygon is not cut.
enum { MOST_CORNERS = 200000 };
static const long long MOST_TESTS = 300000000;

// The outline while it is cut: a ring of places, each of which stands at a point.
typedef struct Outline {
    const Vec2 *points;
    int *at, *next, *prev;
    int count;
} Outline;

static double turn_of(const Vec2 *p, int a, int b, int c) {
    return vec2_cross(vec2_sub(p[b], p[a]), vec2_sub(p[c], p[a]));
}

typedef struct Hole {
    double x;
    int first, size, right;
} Hole;

// From right to left, then by their place in the file.
static int compare_holes(const void *a, const void *b) {
    const Hole *p = a, *q = b;
    if (p->x != q->x) return p->x > q->x ? -1 : 1;
    return p->first < q->first ? -1 : p->first > q->first;
}

static bool in_triangle(Vec2 a, Vec2 b, Vec2 c, Vec2 p) {
    return vec2_cross(vec2_sub(b, a), vec2_sub(p, a)) >= 0 &&
           vec2_cross(vec2_sub(c, b), vec2_sub(p, b)) >= 0 && vec2_cross(vec2_sub(a, c), vec2_sub(p, c)) >= 0;
}

// Does the way from a place to point m begin inside the outline?
static bool begins_inside(const Outline *o, int at, int m) {
    int before = o->at[o->prev[at]], here = o->at[at], after = o->at[o->next[at]];
    bool left_of_in = turn_of(o->points, before, here, m) > 0,
         left_of_out = turn_of(o->points, here, after, m) > 0;
    return turn_of(o->points, before, here, after) > 0 ? left_of_in && left_of_out
                                                       : left_of_in || left_of_out;
}

// Several places may stand at one point, where bridges end: that one from which the way to point m begins inside.
static int facing_place(const Outline *o, int place, int m) {
    Vec2 p = o->points[o->at[place]];
    for (int at = o->next[place]; at != place; at = o->next[at])
        if (vec2_equal(o->points[o->at[at]], p) && begins_inside(o, at, m))
            return begins_inside(o, place, m) ? place : at;
    return place;
}

// The place of the outline that sees point m of a hole, to the right of it (D. Eberly 2008, "Triangulation by ear clipping").
static int bridge_to(const Outline *o, int start, int m) {
    const Vec2 *p = o->points;
    Vec2 from = p[m];
    double best = INFINITY;
    int found = -1, at = start;
    do {
        Vec2 a = p[o->at[at]], b = p[o->at[o->next[at]]];
        // The outline runs upwards to the right of the hole.
        if (a.y <= from.y && from.y <= b.y && a.y != b.y) {
            double x = a.x + (from.y - a.y) / (b.y - a.y) * (b.x - a.x);
            if (x >= from.x && x < best) {
                best = x;
                found = a.x > b.x ? at : o->next[at];
                if (from.y == a.y) found = at;
                if (from.y == b.y) found = o->next[at];
            }
        }
        at = o->next[at];
    } while (at != start);
    if (found < 0) return start;
    Vec2 hit = vec2(best, from.y), end = p[o->at[found]];
    if (vec2_equal(hit, end)) return found;
    // A reflex corner within the triangle hides the end: the one at the smallest angle to the line sees the hole.
    double flattest = INFINITY, nearest = INFINITY;
    int seen = found;
    at = start;
    do {
        Vec2 q = p[o->at[at]];
        if (q.x >= from.x && !vec2_equal(q, end)) {
            bool inside = end.y < from.y ? in_triangle(from, end, hit, q) : in_triangle(from, hit, end, q);
            bool reflex = turn_of(p, o->at[o->prev[at]], o->at[at], o->at[o->next[at]]) <= 0;
            double slope =
                       q.x > from.x ? fabs(q.y - from.y) / (q.x - from.x) : (q.y == from.y ? 0 : INFINITY),
                   far = q.x - from.x;
            if (inside && reflex && (slope < flattest || (slope == flattest && far < nearest))) {
                flattest = slope;
                nearest = far;
                seen = at;
            }
        }
        at = o->next[at];
    } while (at != start);
    return seen;
}

static int add_place(Outline *o, int point, int prev, int next) {
    int at = o->count++;
    o->at[at] = point;
    o->prev[at] = prev;
    o->next[at] = next;
    return at;
}

static void make_outline(Arena *arena, Outline *o, const int *size, int ring_count, int total) {
    int most = total + 2 * ring_count;
    o->at = ARENA_ARRAY(arena, int, most);
    o->next = ARENA_ARRAY(arena, int, most);
    o->prev = ARENA_ARRAY(arena, int, most);
    for (int i = 0; i < size[0]; i++)
        add_place(o, i, i == 0 ? size[0] - 1 : i - 1, i + 1 == size[0] ? 0 : i + 1);
    Hole *holes = ARENA_ARRAY(arena, Hole, ring_count);
    for (int i = 1, first = size[0]; i < ring_count; first += size[i], i++) {
        Hole *h = &holes[i - 1];
        *h = (Hole){-INFINITY, first, size[i], first};
        for (int k = first; k < first + size[i]; k++) {
            if (o->points[k].x > h->x) {
                h->x = o->points[k].x;
                h->right = k;
            }
        }
    }
    qsort(holes, (size_t)(ring_count - 1), sizeof *holes, compare_holes);
    for (int i = 0; i + 1 < ring_count; i++) {
        const Hole *h = &holes[i];
        if (h->size < 3) continue;
        int from = facing_place(o, bridge_to(o, 0, h->right), h->right), after = o->next[from];
        // from -> the hole's ring, from its rightmost point back to it -> from again -> after.
        int last = from;
        for (int k = 0; k <= h->size; k++) {
            int at = add_place(o, h->first + (h->right - h->first + k) % h->size, last, -1);
            o->next[last] = at;
            last = at;
        }
        int again = add_place(o, o->at[from], last, after);
        o->next[last] = again;
        o->prev[after] = again;
    }
}

// Is the corner an ear? Corners at the same points as its own do not count.
static bool is_ear(const Outline *o, int at, const int *reflex, int reflex_count, const bool *gone,
                   long long *tests) {
    const Vec2 *p = o->points;
    int ia = o->at[o->prev[at]], ib = o->at[at], ic = o->at[o->next[at]];
    Vec2 a = p[ia], b = p[ib], c = p[ic];
    double left = fmin(a.x, fmin(b.x, c.x)), right = fmax(a.x, fmax(b.x, c.x)),
           low = fmin(a.y, fmin(b.y, c.y)), high = fmax(a.y, fmax(b.y, c.y));
    *tests += reflex_count;
    for (int i = 0; i < reflex_count; i++) {
        if (gone[reflex[i]]) continue;
        int k = o->at[reflex[i]];
        Vec2 q = p[k];
        if (q.x < left || q.x > right || q.y < low || q.y > high || k == ia || k == ib || k == ic) continue;
        if (vec2_equal(q, a) || vec2_equal(q, b) || vec2_equal(q, c)) continue;
        if (in_triangle(a, b, c, q)) return false;
    }
    return true;
}

// Cuts off ears; writes triangles of points, returns their number, -1 where it takes too long.
static int cut_ears(Arena *arena, Outline *o, int *triangle) {
    int *reflex = ARENA_ARRAY(arena, int, o->count), reflex_count = 0, count = 0, left = o->count;
    bool *gone = ARENA_ARRAY(arena, bool, o->count);
    for (int i = 0; i < o->count; i++)
        if (turn_of(o->points, o->at[o->prev[i]], o->at[i], o->at[o->next[i]]) <= 0)
            reflex[reflex_count++] = i;
    int at = 0, idle = 0, dead = 0;
    long long tests = 0;
    while (left > 2) {
        int before = o->prev[at], after = o->next[at];
        double turn = turn_of(o->points, o->at[before], o->at[at], o->at[after]);
        // Where no corner is an ear, as in outlines that touch themselves, one is cut off all the same.
        bool forced = idle > left;
        bool flat = turn == 0 && (o->at[before] == o->at[after] || idle > left / 2);
        if (flat || forced || (turn > 0 && is_ear(o, at, reflex, reflex_count, gone, &tests))) {
            if (turn > 0) {
                triangle[3 * count] = o->at[before];
                triangle[3 * count + 1] = o->at[at];
                triangle[3 * count + 2] = o->at[after];
                count++;
            }
            o->next[before] = after;
            o->prev[after] = before;
            gone[at] = true;
            left--;
            idle = 0;
            at = after;
            // Reflex corners that were cut off are swept out now and then.
            if (++dead > 64 && dead > reflex_count / 2) {
                int kept = 0;
                for (int i = 0; i < reflex_count; i++) {
                    int k = reflex[i];
                    if (!gone[k] && turn_of(o->points, o->at[o->prev[k]], o->at[k], o->at[o->next[k]]) <= 0)
                        reflex[kept++] = k;
                }
                reflex_count = kept;
                dead = 0;
            }
        } else {
            idle++;
            at = after;
        }
        if (tests > MOST_TESTS) return -1;
    }
    return count;
}

typedef struct Side {
    int low, high, edge;
} Side;
static int compare_sides(const void *a, const void *b) {
    const Side *p = a, *q = b;
    if (p->low != q->low) return p->low < q->low ? -1 : 1;
    if (p->high != q->high) return p->high < q->high ? -1 : 1;
    return p->edge < q->edge ? -1 : p->edge > q->edge;
}

// Joins triangles; edge e runs from point from[e] to that of next[e].
static int join_triangles(Arena *arena, const Vec2 *points, const int *triangle, int count, int *out,
                          int *out_size) {
    int edges = 3 * count;
    int *next = ARENA_ARRAY(arena, int, edges), *prev = ARENA_ARRAY(arena, int, edges),
        *twin = ARENA_ARRAY(arena, int, edges);
    bool *gone = ARENA_ARRAY(arena, bool, edges);
    Side *sides = ARENA_ARRAY(arena, Side, edges);
    for (int e = 0; e < edges; e++) {
        next[e] = e % 3 == 2 ? e - 2 : e + 1;
        prev[e] = e % 3 == 0 ? e + 2 : e - 1;
        twin[e] = -1;
        int a = triangle[e], b = triangle[next[e]];
        sides[e] = (Side){a < b ? a : b, a < b ? b : a, e};
    }
    qsort(sides, (size_t)edges, sizeof *sides, compare_sides);
    for (int i = 0; i + 1 < edges; i++) {
        const Side *a = &sides[i], *b = &sides[i + 1];
        if (a->low == b->low && a->high == b->high && triangle[a->edge] != triangle[b->edge]) {
            twin[a->edge] = b->edge;
            twin[b->edge] = a->edge;
            i++;
        }
    }
    // The first pass keeps corners from lying straight in a side.
    for (int e = 0; e < edges; e++) {
        int t = twin[e];
        if (t < e || gone[e]) continue;
        double one = turn_of(points, triangle[prev[e]], triangle[e], triangle[next[next[t]]]);
        double other = turn_of(points, triangle[prev[t]], triangle[t], triangle[next[next[e]]]);
        if (one < 0 || other < 0 || next[next[e]] == e || next[next[t]] == t) continue;
        // Two polygons that share two edges would make a ring.
        if (next[t] == twin[prev[e]] || next[e] == twin[prev[t]]) continue;
        next[prev[e]] = next[t];
        prev[next[t]] = prev[e];
        next[prev[t]] = next[e];
        prev[next[e]] = prev[t];
        gone[e] = gone[t] = true;
    }
    int pieces = 0, used = 0;
    for (int e = 0; e < edges; e++) {
        if (gone[e]) continue;
        int first = used;
        for (int at = e; !gone[at]; at = next[at]) {
            out[used++] = triangle[at];
            gone[at] = true;
        }
        out_size[pieces++] = used - first;
    }
    return pieces;
}

int convex_pieces(Arena *arena, const Vec2 *points, const int *size, int ring_count, int **out,
                  int **out_size) {
    int total = 0;
    for (int i = 0; i < ring_count; i++) total += size[i];
    if (total > MOST_CORNERS) return -1;
    Outline o = {.points = points};
    make_outline(arena, &o, size, ring_count, total);
    int most = o.count > 2 ? o.count - 2 : 0;
    int *triangle = ARENA_ARRAY(arena, int, 3 * most + 1);
    *out = ARENA_ARRAY(arena, int, 3 * most + 1);
    *out_size = ARENA_ARRAY(arena, int, most + 1);
    int count = cut_ears(arena, &o, triangle);
    if (count < 0) return -1;
    return join_triangles(arena, points, triangle, count, *out, *out_size);
}
