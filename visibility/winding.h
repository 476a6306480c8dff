// winding.h - convex polygons while they are clipped a thousand times: the rest of a portal as seen through others. Corners and
// half-spaces lie in arrays coordinate by coordinate, for four at a time.
#ifndef VISIBILITY_WINDING_H
#define VISIBILITY_WINDING_H

#include "engine/core/lanes.h"
#include "engine/core/vec.h"

enum { WINDING_MAX = 32, WINDING_ROOM = WINDING_MAX + FOUR };
// A portal's plane, and how sure it is: its corners lie off it by up to `bend` metres, and away from its middle the
// error grows by `tilt` a metre. Both are 0 where rounding alone is to blame.
typedef struct Facet {
    Plane plane;
    Vec3 middle;
    double bend, tilt;
} Facet;

// How far the plane may be off at p, metres.
static inline double facet_doubt(const Facet *facet, Vec3 p) {
    if (facet->bend == 0) return 0;
    return facet->bend + facet->tilt * vec3_length(vec3_sub(p, facet->middle));
}

// In the plane of a portal, counter-clockwise about its normal, which points forward: where sightlines go.
typedef struct Winding {
    const Facet *facet;
    int count;
    // [count] corners, and four copies of the first one: these complete the last block of four, and each corner has a next one.
    _Alignas(32) double x[WINDING_ROOM], y[WINDING_ROOM], z[WINDING_ROOM];
} Winding;

static inline Vec3 winding_corner(const Winding *w, int i) { return (Vec3){w->x[i], w->y[i], w->z[i]}; }
// Corner i; winding_close once all `count` are set.
static inline void winding_set(Winding *w, int i, Vec3 p) { w->x[i] = p.x, w->y[i] = p.y, w->z[i] = p.z; }
static inline void winding_close(Winding *w) {
    four_store(w->x + w->count, four_of(w->x[0]));
    four_store(w->y + w->count, four_of(w->y[0]));
    four_store(w->z + w->count, four_of(w->z[0]));
}

void winding_copy(Winding *to, const Winding *from);
Vec3 winding_middle(const Winding *w);
double winding_area(const Winding *w);

// Keeps the half-space plane_distance(keep, p) >= 0. Returns false when no corner lies inside it by more than `slack`, metres: what
// merely touches a plane lets no line through; the winding is then of no more use. Corners within the slack of the plane count as on
// it and stay where they are: no hair-thin edges arise, and the error is the slack, outwards. A winding whose corners are used up
// stays as it is.
bool winding_clip(Winding *w, Plane keep, double slack);

// Half-spaces dot(n, p) >= d, n of unit length.
enum { SEPARATORS_MAX = 2 * WINDING_MAX, SEPARATORS_ROOM = SEPARATORS_MAX + FOUR };
typedef struct Separators {
    int count;
    // [count], and then some that hold everything: they complete the last block of four.
    _Alignas(32) double x[SEPARATORS_ROOM], y[SEPARATORS_ROOM], z[SEPARATORS_ROOM], d[SEPARATORS_ROOM];
} Separators;

static inline Plane separators_at(const Separators *s, int i) {
    return (Plane){{s->x[i], s->y[i], s->z[i]}, s->d[i]};
}
// Adds one; `n` has any length but zero.
void separators_add(Separators *s, Vec3 n, Vec3 through);

enum { KEEP_OTHER, KEEP_EDGES };

// Adds the planes that contain an edge of `edges` and touch `other`, with the two on different sides (tangent separators,
// O(n m)). A line through both crosses each of them between the two, so beyond `other` it stays on the side of `other`,
// and before `edges`, coming towards it, on that of `edges`: `keep` says which. `side` is +1 when `other` lies forward of
// `edges`, -1 when it lies behind. An edge too short to tell its direction, or without such a plane, gives none.
void winding_tangents(const Winding *edges, const Winding *other, int side, int keep, double epsilon,
                      Separators *out);

#endif
