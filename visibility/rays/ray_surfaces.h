// ray_surfaces.h - polygons and curved shapes, made ready to be met by rays: one by one, through a hierarchy of boxes, or through a
// uniform grid. These rays come one by one; those of pictures, which go together, have visibility/hidden/ray_tree.h.
#ifndef RAYS_RAY_SURFACES_H
#define RAYS_RAY_SURFACES_H

#include "visibility/rays/curved_rays.h"

// Items 0 .. polygon_count - 1 are polygons, the others shapes. Points are relative to `origin`.
typedef struct RaySurfaces {
    Vec3 origin;
    struct RayPolygon *polygons;
    struct RayEdges *edges;
    const CurvedRays *curved;
    int *shapes;  // [count - polygon_count] in Building.shapes
    Box *boxes;   // [count]
    Box box;      // of all
    int polygon_count, count;
} RaySurfaces;

// The polygons and shapes to be made ready.
typedef struct RaySource {
    const Building *building;  // its shapes
    const Polygon *polygons;
    const Vec3 *vertices;
    const int *list;    // [list_count] of the polygons
    const int *shapes;  // [shape_count] of the building
    int list_count, shape_count;
} RaySource;
RaySurfaces ray_surfaces_new(const RaySource *source, Arena *arena);

typedef struct SurfaceHit {
    int item;  // -1: nothing
    bool front;
    RayHit at;
} SurfaceHit;

// Tries all surfaces, one by one. Of surfaces in one place that one is met which turns its front to the ray, then the lower item.
SurfaceHit ray_surfaces_brute(const RaySurfaces *surfaces, const Ray *ray);

// A hierarchy of boxes, eight to a node.
typedef struct SurfaceTree {
    const RaySurfaces *surfaces;
    struct SurfaceNode *nodes;  // the root first
    int *items;                 // leaf by leaf
    int node_count, depth;
} SurfaceTree;

// Keeps `surfaces`, which must stay. Rays may be asked of it from many threads.
SurfaceTree surface_tree_new(const RaySurfaces *surfaces, Arena *arena);

SurfaceHit surface_tree_first(const SurfaceTree *tree, const Ray *ray);
bool surface_tree_blocked(const SurfaceTree *tree, const Ray *ray);  // by anything

// A uniform grid.
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
