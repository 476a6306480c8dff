// loops.c - an outline that runs along itself as simple loops: ways there and back cancel each other. Programs write areas apart, and areas
// with holes, as one outline that way, or tell an outline's last edge twice.
#include <stdlib.h>

#include "maps/ifc/ifc_file.h"

// Outlines of more points, or of more pieces of edges, are taken as they are: each point is held against each edge, and each piece against
// each other one.
enum { MOST_POINTS = 1000, MOST_WAYS = 4000 };

// A directed edge between two places of the outline.
typedef struct Way {
    int from, to;
    bool gone;
} Way;

// How far along the edge from a to b point p lies, 0 .. 1 without the ends; -1 where it does not lie on it.
static double place_on(Vec3 a, Vec3 b, Vec3 p) {
    Vec3 d = vec3_sub(b, a), q = vec3_sub(p, a);
    double length = vec3_length(d), along = vec3_dot(q, d) / length;
    if (!(along > IFC_SAME_POINT && along < length - IFC_SAME_POINT)) return -1;
    return vec3_length(vec3_sub(q, vec3_scale(d, along / length))) < IFC_SAME_POINT ? along / length : -1;
}

// The first point at the same place as each one, and whether the outline touches itself at all.
static bool merge_points(const Curve *ring, int *place) {
    bool touches = false;
    for (int i = 0; i < ring->count; i++) {
        place[i] = i;
        for (int k = 0; k < i && place[i] == i; k++)
            if (vec3_length(vec3_sub(ring->points[i], ring->points[k])) < IFC_SAME_POINT) place[i] = k;
        touches |= place[i] != i;
    }
    for (int i = 0; i < ring->count && !touches; i++)
        for (int k = 0; k < ring->count && !touches; k++)
            touches = place_on(ring->points[k], ring->points[(k + 1) % ring->count], ring->points[i]) >= 0;
    return touches;
}

typedef struct Stop {
    double along;
    int place;
} Stop;

static int compare_stops(const void *a, const void *b) {
    const Stop *p = a, *q = b;
    return p->along < q->along ? -1 : p->along > q->along;
}

// The outline's edges, each in the pieces between the places that it touches; no more than MOST_WAYS of them and those of one edge.
static int split_edges(Reader *r, const Curve *ring, const int *place, Way **out) {
    Way *ways = NULL;
    int count = 0, room = 0;
    Stop *stops = ARENA_ARRAY(&r->scratch, Stop, ring->count + 1);
    for (int k = 0; k < ring->count && count <= MOST_WAYS; k++) {
        int next = (k + 1) % ring->count, stop_count = 0, last = place[k];
        for (int i = 0; i < ring->count; i++) {
            double along =
                place[i] == i ? place_on(ring->points[k], ring->points[next], ring->points[i]) : -1;
            if (along >= 0) stops[stop_count++] = (Stop){along, i};
        }
        qsort(stops, (size_t)stop_count, sizeof *stops, compare_stops);
        stops[stop_count++] = (Stop){1, place[next]};
        for (int i = 0; i < stop_count; last = stops[i].place, i++)
            if (stops[i].place != last)
                *ARENA_PUSH(&r->scratch, ways, count, room) = (Way){last, stops[i].place, false};
    }
    *out = ways;
    return count;
}

int ifc_loops(Reader *r, const Curve *ring, Curve **out) {
    int *place = ARENA_ARRAY(&r->scratch, int, ring->count + 1), count = 0, room = 0;
    Curve *loops = NULL;
    if (ring->count > MOST_POINTS || !merge_points(ring, place)) return 0;
    Way *ways;
    int way_count = split_edges(r, ring, place, &ways);
    if (way_count > MOST_WAYS) return 0;
    for (int i = 0; i < way_count; i++)
        for (int k = 0; k < i && !ways[i].gone; k++)
            if (!ways[k].gone && ways[k].from == ways[i].to && ways[k].to == ways[i].from)
                ways[k].gone = ways[i].gone = true;
    // Along what is left: whenever a place comes up again, a loop is closed.
    int *path = ARENA_ARRAY(&r->scratch, int, way_count + 1), length = 0;
    for (;;) {
        int at = length > 0 ? path[length - 1] : -1, next = -1;
        for (int i = 0; i < way_count && next < 0; i++)
            if (!ways[i].gone && (at < 0 || ways[i].from == at)) next = i;
        if (next < 0) break;
        if (at < 0) path[length++] = ways[next].from;
        ways[next].gone = true;
        int begin = 0;
        while (begin < length && path[begin] != ways[next].to) begin++;
        if (begin == length) {
            path[length++] = ways[next].to;
            continue;
        }
        Curve loop = {.closed = true};
        for (int i = begin; i < length; i++) ifc_curve_push(r, &loop, ring->points[path[i]]);
        if (loop.count > 2) *ARENA_PUSH(&r->scratch, loops, count, room) = loop;
        length = begin > 0 ? begin + 1 : 0;
    }
    *out = loops;
    return count;
}
