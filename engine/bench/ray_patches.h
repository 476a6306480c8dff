// ray_patches.h - patches on which intersections with rays are measured and tested: flat and wild, rational, degenerate,
// trimmed.
#ifndef APP_RAY_PATCHES_H
#define APP_RAY_PATCHES_H

#include "maps/building/building.h"

enum { RAY_PATCHES = 12 };
extern const char *const RAY_PATCH_NAMES[RAY_PATCHES];

// A building whose one shape is the patch, about 2 m large, times `scale`.
Building ray_patch_building(int patch, double scale, Arena *arena);

#endif
