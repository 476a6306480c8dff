// winding.c - clipping by separating planes, and the separating planes of two windings.
//
// Source: S. J. Teller, Computing the antipenumbra of an area light source, 1992, for what separating planes bound;
// their use on chains of portals is J. Carmack's (Quake, 1996), who tries all pairs of an edge and a corner. Here the tangent
// corners of four edges are found at once.
#include "visibility/winding.h"

#include "engine/core/polygon.h"

// Edges shorter than this many epsilons have no sure direction: corners are known to an epsilon's thousandth, and an
// error of direction grows over the length of the building, 1e9 or so epsilons.
static const double SHORTEST_EDGE = 1e3;

void winding_copy(Winding *to, const Winding *from) {
    to->facet = from->facet;
    to->count = from->count;
    for (int i = 0; i <= from->count; i += FOUR) {
        four_store(to->x + i, four_load(from->x + i));
        four_store(to->y + i, four_load(from->y + i));
        four_store(to->z + i, four_load(from->z + i));
    }
}

Vec3 winding_middle(const Winding *w) {
    Vec3 sum = {0, 0, 0};
    for (int i = 0; i < w->count; i++) sum = vec3_add(sum, winding_corner(w, i));
    return vec3_scale(sum, 1.0 / w->count);
}

double winding_area(const Winding *w) {
    Vec3 p[WINDING_MAX];
    for (int i = 0; i < w->count; i++) p[i] = winding_corner(w, i);
    return polygon_area(p, w->count);
}

// ---- clipping

// Moves n numbers within a row of corners; the row has room for a block beyond them.
static inline void move_row(double *row, int to, int from, int n) {
    if (n > FOUR)
        memmove(row + to, row + from, (size_t)n * sizeof *row);
    else
        four_store(row + to, four_load(row + from));
}

static inline void move_corners(Winding *w, int to, int from, int n) {
    if (n == 0 || to == from) return;
    move_row(w->x, to, from, n);
    move_row(w->y, to, from, n);
    move_row(w->z, to, from, n);
}

// Where the edge from corner i to corner k crosses the plane.
static inline Vec3 crossing(const Winding *w, const double *distance, int i, int k) {
    return vec3_lerp(winding_corner(w, i), winding_corner(w, k), distance[i] / (distance[i] - distance[k]));
}

// Rounding has put several separate runs of corners outside.
static bool clip_runs(Winding *w, const double *distance, double slack) {
    Vec3 in[WINDING_MAX], out[WINDING_MAX + 1];
    for (int i = 0; i < w->count; i++) in[i] = winding_corner(w, i);
    w->count = polygon_clip_band(in, distance, w->count, slack, out);
    for (int i = 0; i < w->count; i++) winding_set(w, i, out[i]);
    winding_close(w);
    return w->count >= 3;
}

bool winding_clip(Winding *w, Plane keep, double slack) {
    double distance[WINDING_ROOM];
    uint64_t inside = 0, outside = 0;  // a bit for each corner
    int count = w->count;
    for (int i = 0; i < count; i += FOUR) {
        Four at = four_load(w->x + i) * keep.n.x + four_load(w->y + i) * keep.n.y +
                  four_load(w->z + i) * keep.n.z - keep.d;
        four_store(distance + i, at);
        inside |= (uint64_t)four_lanes(at > slack) << i;
        outside |= (uint64_t)four_lanes(at < -slack) << i;
    }
    if (inside == 0) return false;
    outside &= ((uint64_t)1 << count) - 1;
    if (outside == 0 || count == WINDING_MAX) return true;
    uint64_t begins = outside & ~(outside << 1 | outside >> (count - 1));  // the corner before is kept
    if (begins & (begins - 1)) return clip_runs(w, distance, slack);
    // The run first .. end - 1 is cut off; it may go on at the corners' beginning.
    int first = __builtin_ctzll(begins), end = first + __builtin_popcountll(outside);
    int last = first > 0 ? first - 1 : count - 1, next = end < count ? end : end - count, cuts = 0;
    Vec3 cut[2];
    if (distance[last] > slack) cut[cuts++] = crossing(w, distance, last, first);
    if (distance[next] > slack) cut[cuts++] = crossing(w, distance, next > 0 ? next - 1 : count - 1, next);
    int head = first, tail = count - end;
    if (tail <= 0) {
        head += tail;
        move_corners(w, 0, -tail, head);
        tail = 0;
    }
    move_corners(w, head + cuts, end, tail);
    for (int i = 0; i < cuts; i++) winding_set(w, head + i, cut[i]);
    w->count = head + cuts + tail;
    winding_close(w);
    return w->count >= 3;
}

// ---- separating planes

// Four points or vectors.
typedef struct Fours {
    Four x, y, z;
} Fours;

static inline Fours fours_load(const Winding *w, int i) {
    return (Fours){four_load(w->x + i), four_load(w->y + i), four_load(w->z + i)};
}
static inline Fours fours_of(Vec3 p) { return (Fours){four_of(p.x), four_of(p.y), four_of(p.z)}; }
static inline Fours fours_sub(Fours a, Fours b) { return (Fours){a.x - b.x, a.y - b.y, a.z - b.z}; }
static inline Fours fours_scale(Fours a, Four s) { return (Fours){a.x * s, a.y * s, a.z * s}; }
static inline Four fours_dot(Fours a, Fours b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline Fours fours_cross(Fours a, Fours b) {
    return (Fours){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static inline Fours fours_choose(FourMask mask, Fours yes, Fours no) {
    return (Fours){four_choose(mask, yes.x, no.x), four_choose(mask, yes.y, no.y),
                   four_choose(mask, yes.z, no.z)};
}

// The half-spaces behind the last hold everything.
static void complete(Separators *s) {
    four_store(s->x + s->count, four_of(0));
    four_store(s->y + s->count, four_of(0));
    four_store(s->z + s->count, four_of(0));
    four_store(s->d + s->count, four_of(-INFINITY));
}

void separators_add(Separators *s, Vec3 n, Vec3 through) {
    n = vec3_normalize(n);
    int i = s->count++;
    s->x[i] = n.x, s->y[i] = n.y, s->z[i] = n.z;
    s->d[i] = vec3_dot(n, through);
    complete(s);
}

// Adds the half-spaces of some lanes.
static inline void add_lanes(Separators *s, Fours n, Four d, unsigned lanes) {
    int at = s->count;
    four_store(s->x + at, n.x);
    four_store(s->y + at, n.y);
    four_store(s->z + at, n.z);
    four_store(s->d + at, d);
    s->count += __builtin_popcount(lanes);
    if ((lanes & (lanes + 1)) == 0) return;  // the first ones
    for (; lanes; lanes &= lanes - 1, at++) {
        int from = __builtin_ctz(lanes);
        s->x[at] = n.x[from], s->y[at] = n.y[from], s->z[at] = n.z[from], s->d[at] = d[from];
    }
}

// How `other` lies to the plane of `edges`.
typedef struct Heights {
    Vec3 up;                    // the plane's normal, towards `other`
    uint64_t ahead;             // a bit for each corner that surely lies ahead
    double part[WINDING_ROOM];  // 1 / height of each corner
} Heights;

static void find_heights(const Winding *edges, const Winding *other, int side, double epsilon, Heights *out) {
    const Facet *facet = edges->facet;
    Vec3 up = out->up = vec3_scale(facet->plane.n, side);
    double base = side * facet->plane.d;
    out->ahead = 0;
    for (int i = 0; i < other->count; i += FOUR) {
        Fours p = fours_load(other, i);
        Four height = fours_dot(fours_of(up), p) - base, least = four_of(epsilon);
        if (facet->bend > 0) {
            Fours off = fours_sub(p, fours_of(facet->middle));
            least += facet->bend + facet->tilt * four_root(fours_dot(off, off));
        }
        four_store(out->part + i, 1 / height);
        out->ahead |= (uint64_t)four_lanes(height > least) << i;
    }
    out->ahead &= ((uint64_t)1 << other->count) - 1;
}

// Normals of the tangents at four edges of a winding that is flat. Of all planes through an edge the one across the winding's own
// plane, with the normal m, leans over by the least slope dot(m, p - a) / height of a corner p. The edges lie in the plane, and are at
// right angles to m.
static inline Fours lean(const Heights *h, const Winding *other, Fours a, Fours along, int side) {
    Fours m = fours_cross(along, fours_of(vec3_scale(h->up, side)));
    Four base = fours_dot(m, a), least = four_of(INFINITY);
    for (uint64_t left = h->ahead; left; left &= left - 1) {
        int k = __builtin_ctzll(left);
        least = four_least(least, (fours_dot(m, fours_of(winding_corner(other, k))) - base) * h->part[k]);
    }
    return fours_sub(m, fours_scale(fours_of(h->up), least));
}

// The same for one that is bent: the corners are tried one by one, and each that lies behind the plane through the edge and the one
// before takes its place. Corners on an edge's line, within epsilon, span no plane; a normal is zero where there is no other.
static inline Fours turn(const Heights *h, const Winding *other, Fours a, Fours along, int side,
                         double epsilon) {
    Fours n = fours_of((Vec3){0, 0, 0});
    FourMask found = {0};
    along = fours_scale(along, four_of(side));
    Four least = fours_dot(along, along) * (epsilon * epsilon);
    for (uint64_t left = h->ahead; left; left &= left - 1) {
        Fours off = fours_sub(fours_of(winding_corner(other, __builtin_ctzll(left))), a);
        Fours normal = fours_cross(along, off);
        FourMask take = (~found | (fours_dot(n, off) < 0)) & (fours_dot(normal, normal) > least);
        n = fours_choose(take, normal, n);
        found |= take;
    }
    return n;
}

void winding_tangents(const Winding *edges, const Winding *other, int side, int keep, double epsilon,
                      Separators *out) {
    Heights h;
    find_heights(edges, other, side, epsilon, &h);
    double shortest = SHORTEST_EDGE * SHORTEST_EDGE * epsilon * epsilon;
    bool bent = edges->facet->bend > 0;
    // A corner in the plane of the edges themselves may lie on the wrong side of every plane through an edge and a corner ahead.
    uint64_t unsure = ((uint64_t)1 << other->count) - 1;
    if (!bent) unsure &= ~h.ahead;
    for (int i = 0; i < edges->count && h.ahead; i += FOUR) {
        Fours a = fours_load(edges, i), along = fours_sub(fours_load(edges, i + 1), a);
        Fours n = bent ? turn(&h, other, a, along, side, epsilon) : lean(&h, other, a, along, side);
        Four square = fours_dot(n, n);
        n = fours_scale(n, 1 / four_root(square));
        Four d = fours_dot(n, a);
        FourMask good = (fours_dot(along, along) >= shortest) & (square > 0);
        for (uint64_t left = unsure; left; left &= left - 1) {
            Fours p = fours_of(winding_corner(other, __builtin_ctzll(left)));
            good &= fours_dot(n, p) - d >= -epsilon;
        }
        if (keep == KEEP_EDGES) n = fours_scale(n, four_of(-1)), d = -d;
        int rest = edges->count - i;
        add_lanes(out, n, d, four_lanes(good) & (rest < FOUR ? (1u << rest) - 1 : FOUR_ALL));
    }
    complete(out);
}
