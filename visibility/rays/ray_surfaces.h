// ray_surfaces.h - polygons and curved shapes, made ready to be met by rays.
#ifndef RAYS_RAY_SURFACES_H
#define RAYS_RAY_SURFACES_H

#include "engine/core/lanes.h"
#include "visibility/rays/curved_rays.h"

// Four edges of a polygon, from a to b: a x b and b - a, over their length. The last edge fills up the last four.
typedef struct RayEdges {
    Four moment[3], way[3];
} RayEdges;

typedef struct RayPolygon {
    Plane plane;                  // front: counter-clockwise
    int first_edges, edge_count;  // in RaySurfaces.edges; 0: it has no area and is never met
} RayPolygon;

// Items 0 .. polygon_count - 1 are polygons, the others shapes. Points are relative to `origin`.
typedef struct RaySurfaces {
    Vec3 origin;
    RayPolygon *polygons;
    RayEdges *edges;
    const CurvedRays *curved;
    int *shapes;  // [count - polygon_count] in Building.shapes
    Box *boxes;   // [count]
    Box box;      // of all
    int polygon_count, count;
} RaySurfaces;

// Which ones.
typedef struct RaySource {
    const Building *building;  // its shapes
    const Polygon *polygons;
    const Vec3 *vertices;
    const int *list;    // [list_count] of the polygons
    const int *shapes;  // [shape_count] of the building
    int list_count, shape_count;
} RaySource;
RaySurfaces ray_surfaces_new(const RaySource *source, Arena *arena);

// A ray as all of them need it.
typedef struct SurfaceRay {
    Ray ray;              // in the building
    Vec3 origin, moment;  // relative; origin x direction
} SurfaceRay;
SurfaceRay surface_ray(const RaySurfaces *surfaces, const Ray *ray);

typedef struct SurfaceHit {
    int item;  // -1: nothing
    bool front;
    RayHit at;
} SurfaceHit;
static inline SurfaceHit surface_miss(const Ray *ray) {
    return (SurfaceHit){.item = -1, .at = {.t = ray->far}};
}

// Meets one item: replaces `best` where it is nearer. Of surfaces in one place that one is met which turns its front to the ray,
// then the lower item, whatever the order in which they are tried.
void ray_surface_try(const RaySurfaces *surfaces, int item, const SurfaceRay *ray, SurfaceHit *best);
// Is it met at all?
bool ray_surface_blocks(const RaySurfaces *surfaces, int item, const SurfaceRay *ray);

// All of them tried, one by one.
SurfaceHit ray_surfaces_brute(const RaySurfaces *surfaces, const Ray *ray);

// Surfaces nearer than this along a ray lie in one place, metres: above rounding 1e8 m from the origin, below any sheet.
#define RAY_SAME_PLACE 1e-6

#endif
