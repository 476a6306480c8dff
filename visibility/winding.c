// winding.c - clipping by separating planes, and the separating planes of two windings.
//
// Source: S. J. Teller, Computing the antipenumbra of an area light source, 1992, for what separating planes bound;
// their use on chains of portals is J. Carmack's (Quake, 1996), who tries all pairs of an edge and a corner. Here each
// edge finds its tangent corner in one pass.
#include "visibility/winding.h"

#include <string.h>

#include "engine/core/polygon.h"

// Edges shorter than this many epsilons have no sure direction: corners are known to an epsilon's thousandth, and an
// error of direction grows over the length of the building, 1e9 or so epsilons.
static const double SHORTEST_EDGE = 1e3;

Separator separator_of(Vec3 n, Vec3 through, double epsilon) {
    // The sum of the components bounds the length from above, within a factor of 1.8: no root is needed.
    return (Separator){n, vec3_dot(n, through), epsilon * (fabs(n.x) + fabs(n.y) + fabs(n.z))};
}

void winding_copy(Winding *to, const Winding *from) {
    to->facet = from->facet;
    to->count = from->count;
    memcpy(to->p, from->p, (size_t)from->count * sizeof *from->p);
}

Vec3 winding_middle(const Winding *w) {
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < w->count; i++) sum = vec3_add(sum, w->p[i]);
    return vec3_scale(sum, 1.0 / w->count);
}

bool winding_clip(Winding *w, Separator keep) {
    double distance[WINDING_MAX];
    int inside = 0, outside = 0;
    for (int i = 0; i < w->count; i++) {
        distance[i] = vec3_dot(keep.n, w->p[i]) - keep.d;
        inside += distance[i] > keep.slack;
        outside += distance[i] < -keep.slack;
    }
    if (inside == 0) return false;
    if (outside == 0 || w->count == WINDING_MAX) return true;
    Vec3 out[WINDING_MAX + 1];
    int kept = polygon_clip_band(w->p, distance, w->count, keep.slack, out);
    if (kept < 3) return false;
    w->count = kept;
    memcpy(w->p, out, (size_t)kept * sizeof *out);
    return true;
}

// Where a corner is about an edge: the normal of the plane through both.
static Vec3 normal_at(Vec3 a, Vec3 along, const Winding *other, int corner) {
    return vec3_cross(along, vec3_sub(other->p[corner], a));
}

// The corner of `other`, all of which lies ahead of the edge's plane, whose plane with the edge at `a` along `along` has
// all the others in front. Seen along the edge the corners go up to it and down again, so one climbs, from `start`.
static int climb(Vec3 a, Vec3 along, const Winding *other, int start, Vec3 *n) {
    int count = other->count, at = start;
    *n = normal_at(a, along, other, at);
    for (int direction = 1; direction >= -1; direction -= 2) {
        for (int steps = 0; steps < count; steps++) {
            int next = at + direction;
            if (next == count) next = 0;
            if (next < 0) next = count - 1;
            if (vec3_dot(*n, vec3_sub(other->p[next], a)) >= 0) break;
            at = next;
            *n = normal_at(a, along, other, at);
        }
    }
    return at;
}

// The same among the corners that lie ahead, tried one by one; false when all those lie on the edge's line.
static bool tangent(Vec3 a, Vec3 along, const Winding *other, const bool *ahead, double least, Vec3 *n) {
    bool found = false;
    least *= vec3_dot(along, along);
    for (int k = 0; k < other->count; k++) {
        if (!ahead[k]) continue;
        if (found && vec3_dot(*n, vec3_sub(other->p[k], a)) >= 0) continue;
        Vec3 normal = normal_at(a, along, other, k);
        if (vec3_dot(normal, normal) <= least) continue;
        *n = normal;
        found = true;
    }
    return found;
}

// All of `other` lies on the right side, but for rounding. A corner in the plane of the edges themselves may lie on the
// wrong side of every plane through an edge and a corner ahead; and a climb may end early at a doubled corner.
static bool keeps_all(Vec3 a, Separator s, const Winding *other) {
    for (int k = 0; k < other->count; k++) {
        if (vec3_dot(s.n, vec3_sub(other->p[k], a)) < -s.slack) return false;
    }
    return true;
}

int winding_tangents(const Winding *edges, const Winding *other, int side, int keep, double epsilon,
                     Separator *out) {
    bool ahead[WINDING_MAX];
    int ahead_count = 0, count = 0, corner = 0;
    for (int k = 0; k < other->count; k++) {
        ahead[k] = side * plane_distance(edges->facet.plane, other->p[k]) >
                   epsilon + facet_doubt(&edges->facet, other->p[k]);
        ahead_count += ahead[k];
    }
    bool all = ahead_count == other->count;
    if (ahead_count == 0) return 0;
    // Squares: of the shortest edge, and of the distance from an edge's line under which a corner lies on it.
    double shortest = SHORTEST_EDGE * SHORTEST_EDGE * epsilon * epsilon, least = epsilon * epsilon;
    for (int i = 0; i < edges->count; i++) {
        Vec3 a = edges->p[i], n = {0, 0, 0};
        Vec3 along = vec3_scale(vec3_sub(edges->p[i + 1 == edges->count ? 0 : i + 1], a), side);
        if (vec3_dot(along, along) < shortest) continue;
        Separator s;
        bool found = false;
        if (all) {
            corner = climb(a, along, other, corner, &n);
            s = separator_of(n, a, epsilon);
            found = vec3_dot(n, n) > least * vec3_dot(along, along) && keeps_all(a, s, other);
        }
        if (!found) {
            if (!tangent(a, along, other, ahead, least, &n)) continue;
            s = separator_of(n, a, epsilon);
            if (!keeps_all(a, s, other)) continue;
        }
        out[count++] = keep == KEEP_OTHER ? s : (Separator){vec3_scale(s.n, -1), -s.d, s.slack};
    }
    return count;
}
