// flat_hit.h - rays against polygons, concave ones too, and boxes along the axes.
#ifndef RAYS_FLAT_HIT_H
#define RAYS_FLAT_HIT_H

#include "visibility/bezier/hit_list.h"

// Of a simple polygon, or of several loops joined by seams, with its plane. No ray slips between polygons that share an
// edge: their corners decide, exactly, and nothing that is computed of one polygon alone.
void polygon_hits(const Vec3 *vertices, int count, Plane plane, const Ray *ray, HitList *list);
void box_hits(const Box *box, const Ray *ray, HitList *list);

#endif
