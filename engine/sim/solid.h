// solid.h - convex solids against an upright disc: how far the disc moves before it touches one, how near it is, and
// which heights of a solid lie over the disc. Pure geometry: knows no building.
#ifndef WALK_SOLID_H
#define WALK_SOLID_H

#include "engine/core/vec.h"

// A convex plane polygon, or an upright prism over a convex plan.
typedef struct Solid {
    const Vec3 *vertices;  // [count] building space; of a prism its plan, counter-clockwise from above
    int count;
    bool prism;
    bool steep;  // too steep to stand on; used by the caller only
    Box box;
} Solid;

// A range of heights, metres. It is open at both ends: a solid that only touches the range is outside.
typedef struct Band {
    double z0, z1;
} Band;

// How near the part of a solid within the band comes to `at` in plan; 0 inside its outline, INFINITY if the band holds no part.
double solid_distance(const Solid *solid, Band band, Vec2 at);

// The share of `way` that a disc goes before its middle is at distance `radius` from the part of the solid within the band; 1 if
// the disc never comes so near. Below 1, `normal` points from the solid to the disc. A solid that is already nearer stops the disc
// only if the way leads nearer still. `from` must lie outside the part's outline.
double solid_sweep(const Solid *solid, Band band, Vec2 from, Vec2 way, double radius, Vec2 *normal);

// The range of heights of the part of a solid that lies over or under the disc; false where there is no such part.
bool solid_levels(const Solid *solid, Vec2 at, double radius, Band *out);

// The gap between two convex plans, metres: the widest one over the normals of their edges; below 0, how deep they overlap.
double solid_gap(const Vec2 *a, int a_count, const Vec2 *b, int b_count);

#endif
