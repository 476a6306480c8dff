// ray.h - a ray, and where it hits.
#ifndef RAYS_RAY_H
#define RAYS_RAY_H

#include "engine/core/vec.h"

// The points origin + t direction with near < t < far. The direction has unit length, so t counts metres.
typedef struct Ray {
    Vec3 origin, direction;
    double near, far;
} Ray;

typedef struct RayHit {
    double t;
    // Unit; out of solids (spheres, cylinders, ...), a polygon's front, along dP/du x dP/dv of a patch.
    Vec3 normal;
    double u, v;  // of a patch: its parameters; else 0
} RayHit;

// Counts of the work of finding hits, to compare methods by.
typedef struct CurvedWork {
    long long rays, clips, splits, steps;  // asked; Bezier clips; halvings; steps of Newton
    long long undecided;                   // where the iteration was ended by its bound
} CurvedWork;

#endif
