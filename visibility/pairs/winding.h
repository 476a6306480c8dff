// winding.h - convex polygons while they are clipped a thousand times: what is left of a portal as seen through others.
#ifndef VISIBILITY_PAIRS_WINDING_H
#define VISIBILITY_PAIRS_WINDING_H

#include "engine/core/vec.h"

enum { WINDING_MAX = 32 };
// In the plane of a portal, counter-clockwise about its normal, which points forward: where sightlines go.
typedef struct Winding {
    Plane plane;
    double bend;  // how far the portal's corners lie off its plane, metres
    int count;
    Vec3 p[WINDING_MAX];
} Winding;

// A half-space dot(n, p) >= d; n has any length, `slack` is what an epsilon in metres is along it.
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

// Half-spaces that hold, behind `second`, every line that comes through `first` and then `second`: an edge of one and a
// corner of the other, with the two on different sides (tangent separators, O(n m)). `forward` is +1 when such lines go
// along the normals, -1 when they come against them. Returns how many were written, at most first->count +
// second->count. An edge too short to tell its direction, or without such a plane, gives none.
int winding_separators(const Winding *first, const Winding *second, int forward, double epsilon,
                       Separator *out);

#endif
