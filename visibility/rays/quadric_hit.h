// quadric_hit.h - rays against spheres, ellipsoids, cylinders and cones.
#ifndef RAYS_QUADRIC_HIT_H
#define RAYS_QUADRIC_HIT_H

#include "maps/building/curved.h"
#include "visibility/bezier/hit_list.h"

typedef struct Quadric {
    CurvedKind kind;
    Vec3 centre;  // of the shape, in the building
    Vec3 to_unit
        [3];  // dot products of p - centre with these are p in the shape's own space, its centre the origin
    double slope;  // by how much the radius grows with z, -1 .. 0
    bool disc[2];
    Box box;
} Quadric;

Quadric quadric_of(const CurvedShape *shape);
void quadric_hits(const Quadric *quadric, const Ray *ray, HitList *list);

#endif
