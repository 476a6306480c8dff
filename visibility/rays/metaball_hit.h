// metaball_hit.h - rays against surfaces of metaballs.
#ifndef RAYS_METABALL_HIT_H
#define RAYS_METABALL_HIT_H

#include "maps/building/building.h"
#include "visibility/bezier/hit_list.h"
#include "visibility/rays/curved_rays.h"

// Of w = 1 - (r / radius)^2, at the ends and the middle (in Bernstein's basis) of an interval, the coefficients of the field
// weight (5 w^2 + 4 w^3) / 9 there, which is that of CurvedBall, are added to `field`.
void metaball_add_field(const double w[3], double weight, double field[7]);

typedef struct Metaballs Metaballs;
Metaballs *metaballs_new(const Building *building, const CurvedShape *shape, Arena *arena);
Box metaballs_box(const Metaballs *balls);
void metaball_hits(const Metaballs *balls, const Ray *ray, HitList *list, CurvedWork *work);

#endif
