// still_scene.h - a building as the rays of a still meet it: its polygons where doors stand, and its curved shapes exactly.
#ifndef STILLS_STILL_SCENE_H
#define STILLS_STILL_SCENE_H

#include "engine/stills/glass.h"
#include "radiosity/mesh/mesh.h"
#include "visibility/rays/ray_surfaces.h"

// The hierarchy or the grid that rays go through.
enum { STILL_TREE_OWN, STILL_TREE_GRID, STILL_TREES };
extern const char *const STILL_TREE_NAMES[STILL_TREES];

// The surface that a ray meets.
typedef struct StillSurface {
    const Material *material;
    int face;   // the face of the mesh that has its light; -1: none, or a shape
    int shape;  // index in Building.shapes, -1: a polygon
    int body;   // the closed, see-through body that it bounds, by number; -1: none
    int object;
    int texture_map;  // in Building; 0: that of the material
    double open;      // how far the leaf that it moves with is open, 0 .. 1
} StillSurface;

// Some of the surfaces, with the structure that finds them along a ray.
typedef struct StillRays StillRays;

typedef struct StillScene {
    const Mesh *mesh;
    Vec3 *vertices;          // of the graph, where doors stand
    StillRays *all;          // the surfaces that are seen
    StillRays *opaque;       // the surfaces that hide lamps: all but glass
    StillRays *facets;       // the polygons of shapes, which hold the shapes' light
    StillSurface *surfaces;  // one for each of `all`
    int *facet_face;         // the face in the mesh of each of `facets`, -1: none
    int body_count;
} StillScene;

// `door_open` [opening_count] must be that with which the mesh was made; NULL: doors stand as drawn.
StillScene *still_scene_new(const Mesh *mesh, const float *door_open, int tree, Arena *arena);

// The reflectance of a surface at a point, averaged over about `width` metres, and its opacity 0 .. 1: in proportion to the material's
// picture and to the picture's means (texture_at); without a picture, reflectance and alpha of the material.
Texel still_texel(const StillScene *scene, const StillSurface *surface, Vec3 point, double width);

// The first of the shape's polygons, in the graph.
int still_first_polygon(const CellGraph *graph, const CurvedShape *shape);

SurfaceHit still_rays_first(const StillRays *rays, const Ray *ray);
bool still_rays_blocked(const StillRays *rays, const Ray *ray);

// Rays from a surface begin at this distance, metres: above the rounding of positions, below the thickness of any sheet.
#define STILL_NEAR 1e-6
static inline Ray still_ray(Vec3 from, Vec3 direction) {
    return (Ray){from, direction, STILL_NEAR, INFINITY};
}
static inline Vec3 still_ray_at(const Ray *ray, double t) {
    return vec3_add(ray->origin, vec3_scale(ray->direction, t));
}

// The bodies around a point, the innermost last.
Media still_scene_media(const StillScene *scene, Vec3 point);

#endif
