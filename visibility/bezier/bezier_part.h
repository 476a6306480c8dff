// bezier_part.h - part of a patch seen along a ray: distances of its control points to two lines through the ray. What is
// done to it is linear in these.
#ifndef RAYS_BEZIER_PART_H
#define RAYS_BEZIER_PART_H

#include "visibility/bezier/bezier_patch.h"

typedef struct BezierPart {
    Vec2 along_u, along_v;          // the lines, unit vectors in the plane across the ray
    Four a[4];                      // distances to the line along v; rows of v, lanes along u
    Four b[4];                      // to the line along u; rows of u, lanes along v
    double u, v, width_u, width_v;  // where it is in its piece
} BezierPart;

// From coordinates f and g in the plane, rows of v. Lines are along the mean tangents; `for_clips` the second is across the
// first where these are nearly one: only so is a part clipped along both.
void bezier_part_measure(BezierPart *part, const Four f[4], const Four g[4], bool for_clips);
// False: no root of the part is where all distances are more than slack. Else from .. to, in u and v, hold all roots.
bool bezier_part_clip(const BezierPart *part, double slack, double from[2], double to[2]);
void bezier_part_cut(BezierPart *part, const double from[2], const double to[2]);
// Measures it anew, and halves it across the longer of its mean tangents.
void bezier_part_halve(BezierPart *first, BezierPart *second);
bool bezier_part_is_zero(const BezierPart *part, double slack);  // all distances are within slack
bool bezier_part_has_one_root_at_most(const BezierPart *part);

// Both distances at a place of the part, and their derivatives.
typedef struct BezierPlace {
    double a, a_u, a_v, b, b_u, b_v;
} BezierPlace;
BezierPlace bezier_part_place(const BezierPart *part, double u, double v);
typedef struct BezierBends {
    double a_uu, a_uv, a_vv, b_uu, b_uv, b_vv;
} BezierBends;
BezierBends bezier_part_bends(const BezierPart *part, double u, double v);

#endif
