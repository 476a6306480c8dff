// curved_patch.h - points, derivatives and borders of rational bicubic Bezier patches, and points of their trims.
//
// Source: G. Farin, Curves and Surfaces for CAGD, 1997, chapters 13 and 15.
#ifndef MAPS_CURVED_PATCH_H
#define MAPS_CURVED_PATCH_H

#include "maps/building/curved.h"

// Parameters of points that neighbours share are multiples of this, so that 1 - t is exact.
#define CURVED_GRID 0x1p-40
static inline double curved_snap(double t) { return nearbyint(t / CURVED_GRID) * CURVED_GRID; }
// The parameter after i of n equal steps; curved_step(n - i, n) is exactly 1 - curved_step(i, n).
static inline double curved_step(int i, int n) {
    return 2 * i <= n ? curved_snap((double)i / n) : 1 - curved_snap((double)(n - i) / n);
}

enum { PATCH_CONTROLS = 16 };

typedef struct PatchPoint {
    Vec3 point, du, dv;
    // Unit, along du x dv; the limit of this where a border is collapsed to a point; zero where there is no normal.
    Vec3 normal;
} PatchPoint;

// Evaluate a patch at parameters 0 .. 1. At a corner of the patch the point is the control there, to the last bit.
Vec3 curved_patch_point(const CurvedControl control[PATCH_CONTROLS], double u, double v);
PatchPoint curved_patch_at(const CurvedControl control[PATCH_CONTROLS], double u, double v);

// Writes a border of a patch as a rational cubic curve in the direction of u or v. `border` 0: v = 0, 1: u = 1, 2: v = 1, 3: u = 0.
void curved_patch_border(const CurvedControl control[PATCH_CONTROLS], int border, CurvedControl out[4]);
// The point of a curve at t. The reversed curve has the same point, to the last bit, at 1 - t where 1 - t is exact.
Vec3 curved_curve_point(const CurvedControl control[4], double t);

Vec2 curved_trim_point(const CurvedTrim *trim, double t);

#endif
