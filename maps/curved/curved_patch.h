// curved_patch.h - points, derivatives and borders of rational bicubic Bezier patches, and points of their trims.
//
// Source: G. Farin, Curves and Surfaces for CAGD, 1997, chapters 13 and 15.
#ifndef MAPS_CURVED_PATCH_H
#define MAPS_CURVED_PATCH_H

#include "maps/building/curved.h"

// Parameters of points that neighbours share are multiples of this, so that 1 - t is exact.
#define CURVED_GRID 0x1p-40
static inline double curved_snap(double t) { return nearbyint(t / CURVED_GRID) * CURVED_GRID; }
// The i-th of n steps; the same step counted from the other end is the same point.
static inline double curved_step(int i, int n) {
    return 2 * i <= n ? curved_snap((double)i / n) : 1 - curved_snap((double)(n - i) / n);
}

enum { PATCH_CONTROLS = 16 };

typedef struct PatchPoint {
    Vec3 point, du, dv;
    // Unit, along du x dv; its limit where a border is drawn together to a point; zero where there is none.
    Vec3 normal;
} PatchPoint;

// At parameters 0 .. 1. At a corner the point is its control, to the last bit.
Vec3 curved_patch_point(const CurvedControl control[PATCH_CONTROLS], double u, double v);
PatchPoint curved_patch_at(const CurvedControl control[PATCH_CONTROLS], double u, double v);

// A border of a patch as a rational cubic curve: 0: v = 0, 1: u = 1, 2: v = 1, 3: u = 0, in the direction of u or v.
void curved_patch_border(const CurvedControl control[PATCH_CONTROLS], int border, CurvedControl out[4]);
// The same point, to the last bit, as of the curve turned round at 1 - t, where 1 - t is exact.
Vec3 curved_curve_point(const CurvedControl control[4], double t);

Vec2 curved_trim_point(const CurvedTrim *trim, double t);

#endif
