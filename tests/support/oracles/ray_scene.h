// ray_scene.h - the nearest polygon along any ray, in double precision: slow, simple, the oracle of every method.
#ifndef TESTS_RAY_SCENE_H
#define TESTS_RAY_SCENE_H

#include "visibility/hidden/facets.h"

typedef struct RayScene RayScene;

// Polygons without area are left out. NULL, and a sentence, where facets_new refuses.
RayScene *ray_scene_new(const Scene *scene, Arena *arena, Error *error);

// The nearest polygon along eye + z * ray, z > 0, or -1. Nearest by depth_key, then by list order: so coincident surfaces,
// equal but for the last bits of a double, go to the first in the list.
int ray_scene_nearest(const RayScene *rays, Vec3 eye, Vec3 ray, float *z);
int ray_scene_nearest_brute(const RayScene *rays, Vec3 eye, Vec3 ray,
                            float *z);  // the same without hierarchy

#endif
