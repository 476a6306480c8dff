// raycast.h - one ray a pixel in double precision: slow, simple, the oracle of every other method.
#ifndef VISIBILITY_RAYCAST_H
#define VISIBILITY_RAYCAST_H

#include "visibility/hidden/hidden.h"

// A polygon whose plane passes the eye nearer than this is seen edge-on, by no pixel: metres. Far above the
// rounding of coordinates (1e-15 of a building's size), far below the distance of any real sheet from an eye.
#define HIDDEN_EDGE_ON 1e-9

typedef struct RayScene RayScene;

// Polygons without area are left out. The scene's arrays must outlive the result.
RayScene *ray_scene_new(const Scene *scene, Arena *arena);

// The nearest polygon along eye + z * ray, z > 0, or -1. Nearest by z rounded to float, then by list order: so
// coincident surfaces, equal but for the last bits of a double, go to the first in the list.
int ray_scene_nearest(const RayScene *rays, Vec3 eye, Vec3 ray, float *z);
int ray_scene_nearest_brute(const RayScene *rays, Vec3 eye, Vec3 ray,
                            float *z);  // the same without hierarchy

extern const HiddenMethod HIDDEN_RAYCAST;

#endif
