// simplify.h - triangles made fewer by collapsing edges, until no more can go within a tolerance.
#ifndef RADIOSITY_SIMPLIFY_H
#define RADIOSITY_SIMPLIFY_H

#include "engine/core/arena.h"
#include "engine/core/vec.h"

typedef struct SimplifyTriangle {
    int corner[3];  // in `points`, counter-clockwise from its front
    int tag;        // where two tags meet the border stays within the tolerance; -1: gone
} SimplifyTriangle;

typedef struct SimplifySurface {
    const Vec3 *points;           // [point_count] each place once
    const unsigned char *locked;  // [point_count] stays where it is
    int point_count;
    SimplifyTriangle *triangles;  // [triangle_count]
    int triangle_count;
} SimplifySurface;

// Moves corners of triangles to those of others, and drops what then has no area. What was closed stays closed, nothing is turned
// over, and no corner leaves the planes of the triangles that it stands for by more than the tolerance, metres. Triangles that
// are left come first; returns how many. The same input gives the same result.
int simplify(SimplifySurface *surface, double tolerance);

#endif
