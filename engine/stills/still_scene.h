// still_scene.h - a building as the rays of a still meet it: its polygons where doors stand, and its curved shapes exactly.
#ifndef STILLS_STILL_SCENE_H
#define STILLS_STILL_SCENE_H

#include "engine/stills/glass.h"
#include "radiosity/mesh/mesh.h"
#include "visibility/rays/ray_surfaces.h"

// The hierarchy or the grid that rays go through.
enum { STILL_TREE_OWN, STILL_TREE_GRID, STILL_TREES };
extern const char *const STILL_TREE_NAMES[STILL_TREES];

// The surface met there.
typedef struct StillSurface {
    const Material *material;
    int face;   // in the mesh, where its light is; -1: none, or a shape
    int shape;  // in Building.shapes, -1: a polygon
    int body;   // what it bounds, by number, where that is closed and see-through; else -1
    int object;
} StillSurface;

// Some of the surfaces, and what finds them.
typedef struct StillRays StillRays;

typedef struct StillScene {
    const Mesh *mesh;
    Vec3 *vertices;          // of the graph, where doors stand
    StillRays *all;          // what is seen
    StillRays *opaque;       // what hides lamps: all but glass
    StillRays *facets;       // the polygons of shapes, which have light
    StillSurface *surfaces;  // one for each of `all`
    int *facet_face;         // of each of `facets`, in the mesh, -1: none
    int body_count;
} StillScene;

// `door_open` [opening_count] as the mesh was made with; NULL: as drawn.
StillScene *still_scene_new(const Mesh *mesh, const float *door_open, int tree, Arena *arena);

// The shape's polygons, in the graph.
int still_first_polygon(const CellGraph *graph, const CurvedShape *shape);

SurfaceHit still_rays_first(const StillRays *rays, const Ray *ray);
bool still_rays_blocked(const StillRays *rays, const Ray *ray);

// Where rays from a surface begin, metres: above the rounding of places, below any sheet.
#define STILL_NEAR 1e-6
static inline Ray still_ray(Vec3 from, Vec3 direction) {
    return (Ray){from, direction, STILL_NEAR, INFINITY};
}
static inline Vec3 still_ray_at(const Ray *ray, double t) {
    return vec3_add(ray->origin, vec3_scale(ray->direction, t));
}

// The bodies around a point.
Media still_scene_media(const StillScene *scene, Vec3 point);

#endif
