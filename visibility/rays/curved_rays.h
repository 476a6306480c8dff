// curved_rays.h - where rays hit the curved shapes of a building, exactly.
#ifndef RAYS_CURVED_RAYS_H
#define RAYS_CURVED_RAYS_H

#include "engine/core/arena.h"
#include "maps/building/building.h"
#include "visibility/bezier/ray.h"

// All curved shapes of a building, made ready for rays. Rays may be asked of it from many threads at once.
typedef struct CurvedRays CurvedRays;
CurvedRays *curved_rays_new(const Building *building, Arena *arena);
// The shape's bounds; they hold all of it.
Box curved_rays_box(const CurvedRays *rays, int shape);
// The first hit with near < t < far, from either side; `work` may be NULL.
bool curved_rays_hit(const CurvedRays *rays, int shape, const Ray *ray, RayHit *hit, CurvedWork *work);
// All of them, the nearest first: writes at most `max` (2 at least), returns how many there are. Where a ray touches without
// passing through, that is one.
int curved_rays_all(const CurvedRays *rays, int shape, const Ray *ray, RayHit *hits, int max,
                    CurvedWork *work);

// Adds to `field` the coefficients of the field weight (5 w^2 + 4 w^3) / 9 of a CurvedBall over an interval of a ray, given
// w = 1 - (r / radius)^2 at the interval's ends and middle (in Bernstein's basis).
void metaball_add_field(const double w[3], double weight, double field[7]);

#endif
