// ray_caster.h - the faces of a mesh in Embree: the nearest face along each of eight rays.
#ifndef RADIOSITY_RAY_CASTER_H
#define RADIOSITY_RAY_CASTER_H

#include "engine/core/lanes.h"
#include "radiosity/mesh/mesh.h"

typedef struct RayCaster RayCaster;
RayCaster *ray_caster_new(const Mesh *mesh, Arena *arena);
void ray_caster_end(RayCaster *scene);

// Eight unit directions in building space.
typedef struct RayEight {
    Lane x, y, z;
} RayEight;
// Casts eight rays from `eye`, a point of a surface with this normal. `coherent`: the eight go nearly the same way. Only rays of
// `mask` are cast. `face` is in Mesh.faces, -1: nothing was met; `element` is -1 where nothing or a back was met.
void ray_caster_cast(RayCaster *scene, Vec3 eye, Vec3 normal, const RayEight *rays, LaneInt mask,
                     bool coherent, int32_t face[LANES], int32_t element[LANES]);

#endif
