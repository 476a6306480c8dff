// ray_grid.h - a uniform grid over what rays may meet.
#ifndef RAYS_RAY_GRID_H
#define RAYS_RAY_GRID_H

#include "visibility/rays/ray_surfaces.h"

typedef struct SurfaceGrid {
    const RaySurfaces *surfaces;
    Vec3 low, size;  // relative, as surfaces are; of a cell
    int count[3];    // cells along each axis
    int *first;      // [cells + 1] in `items`
    int *items;      // cell by cell, x running first
} SurfaceGrid;

// Keeps `surfaces`, which must stay. Rays may be asked of it from many threads.
SurfaceGrid surface_grid_new(const RaySurfaces *surfaces, Arena *arena);

SurfaceHit surface_grid_first(const SurfaceGrid *grid, const Ray *ray);
bool surface_grid_blocked(const SurfaceGrid *grid, const Ray *ray);  // by anything

#endif
