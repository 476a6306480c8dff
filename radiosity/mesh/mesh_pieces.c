// mesh_pieces.c - elements that something stands on in part, cut into what is open and what is covered.
#include <string.h>

#include "engine/core/polygon.h"
#include "radiosity/mesh/mesh_parts.h"

// Nothing thinner is cut off, metres.
static const double THIN = 1e-3;
// Two that look so much against each other, as a cosine, are two sides of one place.
static const double OPPOSITE = 0.99;

// A cut through a vertex, but for rounding, leaves an edge there that runs anywhere.
static bool is_rounding(Vec3 edge) { return vec3_dot(edge, edge) < MESH_WELD * MESH_WELD; }

// The direction inwards from a side of a polygon about the normal n; false: the side is rounding.
static bool inwards_of(const Vec3 *v, int count, int side, Vec3 n, Vec3 *out) {
    Vec3 edge = vec3_sub(v[side + 1 < count ? side + 1 : 0], v[side]);
    if (is_rounding(edge)) return false;
    *out = vec3_normalize(vec3_cross(n, edge));
    return true;
}

int mesh_sides(const Vec3 *v, int count, Vec3 n, Plane *out) {
    int sides = 0;
    Vec3 inwards;
    for (int i = 0; i < count; i++)
        if (inwards_of(v, count, i, n, &inwards)) out[sides++] = (Plane){inwards, vec3_dot(inwards, v[i])};
    return sides;
}

double mesh_inside(const Vec3 *v, int count, Vec3 n, Vec3 point) {
    double least = INFINITY;
    Vec3 inwards;
    for (int i = 0; i < count; i++)
        if (inwards_of(v, count, i, n, &inwards))
            least = fmin(least, vec3_dot(inwards, vec3_sub(point, v[i])));
    return least;
}

// How long a line is within a convex polygon, metres.
static double length_in(const MeshCut *cut, const Vec3 *v, int count, Vec3 n) {
    double t0 = 0, t1 = 1;
    for (int i = 0; i < count; i++) {
        Vec3 edge = vec3_sub(v[i + 1 < count ? i + 1 : 0], v[i]);
        if (is_rounding(edge)) continue;
        Vec3 inwards = vec3_cross(n, edge);
        double from = vec3_dot(inwards, vec3_sub(cut->from, v[i])),
               to = vec3_dot(inwards, vec3_sub(cut->to, v[i]));
        if (from <= 0 && to <= 0) return 0;
        if (from < 0) t0 = fmax(t0, from / (from - to));
        if (to < 0) t1 = fmin(t1, from / (from - to));
    }
    return t1 <= t0 ? 0 : (t1 - t0) * vec3_length(vec3_sub(cut->to, cut->from));
}

// Are parts of the polygon on both sides, thick enough to count?
static bool crosses(Plane plane, const Vec3 *v, int count) {
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < count; i++) {
        double d = plane_distance(plane, v[i]);
        low = fmin(low, d);
        high = fmax(high, d);
    }
    return low < -THIN && high > THIN;
}

static MeshPiece half(const MeshPiece *piece, Plane keep, Arena *arena) {
    MeshPiece out = {.v = ARENA_ARRAY(arena, Vec3, piece->count + 1), .element = -1};
    out.count = polygon_clip(piece->v, piece->count, keep, 0, out.v);
    return out;
}

static double distance_to(const MeshCut *cut, Vec3 point) {
    Vec3 along = vec3_sub(cut->to, cut->from), off = vec3_sub(point, cut->from);
    double t = vec3_dot(along, off) / vec3_dot(along, along);
    return vec3_length(vec3_sub(off, vec3_scale(along, fmin(fmax(t, 0), 1))));
}

// Cuts as near to a point as any that is farther than some distance.
typedef struct Nearest {
    const MeshCut *cuts[16];  // the first so many
    int count;
    double distance;
} Nearest;

static Nearest nearest_beyond(const MeshBuilder *builder, int face, Vec3 point, double beyond) {
    Nearest n = {.distance = INFINITY};
    for (int i = builder->first_cut[face]; i < builder->first_cut[face + 1]; i++) {
        const MeshCut *cut = &builder->cuts[i];
        if (vec3_dot(cut->open, cut->open) == 0) continue;
        double distance = distance_to(cut, point);
        if (distance <= beyond || distance > n.distance + THIN) continue;
        if (distance < n.distance - THIN) n.count = 0;
        n.distance = fmin(n.distance, distance);
        if (n.count < (int)(sizeof n.cuts / sizeof *n.cuts)) n.cuts[n.count++] = cut;
    }
    return n;
}

// Does another one there look the other way? Of two boxes side by side, or of a wall without thickness, that says nothing.
static bool is_answered(const Nearest *n, const MeshCut *cut) {
    for (int i = 0; i < n->count; i++) {
        double facing = vec3_dot(vec3_normalize(n->cuts[i]->open), vec3_normalize(cut->open));
        if (facing < -OPPOSITE) return true;
    }
    return false;
}

// As the nearest cut has it.
static bool is_covered(const MeshBuilder *builder, int face, Vec3 point) {
    for (double beyond = -1;;) {
        Nearest n = nearest_beyond(builder, face, point, beyond);
        if (n.count == 0) return false;
        // At a corner two lines are nearest: what is before either is open.
        double most = -INFINITY;
        for (int i = 0; i < n.count; i++) {
            if (is_answered(&n, n.cuts[i])) continue;
            most = fmax(most, vec3_dot(n.cuts[i]->open, vec3_sub(point, n.cuts[i]->from)));
        }
        if (most > -INFINITY) return most < 0;
        beyond = n.distance + THIN;
    }
}

// ---- pieces

Vec3 mesh_middle(const MeshPiece *piece) {
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < piece->count; i++) sum = vec3_add(sum, piece->v[i]);
    return vec3_scale(sum, 1.0 / piece->count);
}

int mesh_cut_pieces(const MeshBuilder *builder, int face, const Vec3 *v, int count, Arena *arena,
                    MeshPiece *out) {
    Vec3 n = builder->mesh->faces[face].plane.n;
    int pieces = 1;
    out[0] = (MeshPiece){.v = ARENA_ARRAY(arena, Vec3, count), .count = count, .element = -1};
    memcpy(out[0].v, v, (size_t)count * sizeof *v);
    for (int i = builder->first_cut[face]; i < builder->first_cut[face + 1]; i++) {
        const MeshCut *cut = &builder->cuts[i];
        Vec3 across = vec3_normalize(vec3_cross(n, vec3_sub(cut->to, cut->from)));
        Plane before = {across, vec3_dot(across, cut->from)}, behind = {vec3_scale(across, -1), -before.d};
        // Those that the line itself runs through, not what lies beyond its ends.
        for (int k = 0, end = pieces; k < end && pieces < MESH_MOST_PIECES; k++) {
            MeshPiece whole = out[k];
            if (!crosses(before, whole.v, whole.count) || length_in(cut, whole.v, whole.count, n) < THIN)
                continue;
            out[k] = half(&whole, before, arena);
            out[pieces++] = half(&whole, behind, arena);
        }
    }
    for (int k = 0; k < pieces && builder->first_cut[face + 1] > builder->first_cut[face]; k++)
        out[k].covered = out[k].count >= 3 && is_covered(builder, face, mesh_middle(&out[k]));
    return pieces;
}
