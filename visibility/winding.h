// winding.h - convex polygons while they are clipped a thousand times: the rest of a portal as seen through others.
#ifndef VISIBILITY_WINDING_H
#define VISIBILITY_WINDING_H

#include "engine/core/vec.h"

enum { WINDING_MAX = 32 };
// A portal's plane, and how sure it is: its corners lie off it by up to `bend` metres, and away from its middle the
// error grows by `tilt` a metre.
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
    Facet facet;
    int count;
    Vec3 p[WINDING_MAX];
} Winding;

// A half-space dot(n, p) >= d; n has any length, `slack` is an epsilon in metres times that length.
typedef struct Separator {
    Vec3 n;
    double d, slack;
} Separator;

Separator separator_of(Vec3 n, Vec3 through, double epsilon);

void winding_copy(Winding *to, const Winding *from);
Vec3 winding_middle(const Winding *w);

// Keeps what lies in the half-space. Returns false when no corner lies inside it by more than its slack: what merely
// touches a plane lets no line through. Corners within the slack of the plane count as on it and stay where they are:
// no hair-thin edges arise, and the error is the slack, outwards. A winding whose corners are used up stays as it is.
bool winding_clip(Winding *w, Separator keep);

enum { KEEP_OTHER, KEEP_EDGES };

// The planes that contain an edge of `edges` and touch `other`, with the two on different sides (tangent separators,
// O(n m)). A line through both crosses each of them between the two, so beyond `other` it stays on the side of `other`,
// and before `edges`, coming towards it, on that of `edges`: `keep` says which. `side` is +1 when `other` lies forward of
// `edges`, -1 when it lies behind. Returns how many were written, at most edges->count. An edge too short to tell its
// direction, or without such a plane, gives none.
int winding_tangents(const Winding *edges, const Winding *other, int side, int keep, double epsilon,
                     Separator *out);

#endif
