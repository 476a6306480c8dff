// bezier_clip.h - rays against rational bicubic Bezier patches, by Bezier clipping.
#ifndef RAYS_BEZIER_CLIP_H
#define RAYS_BEZIER_CLIP_H

#include "visibility/bezier/bezier_patch.h"
#include "visibility/bezier/hit_list.h"

void bezier_hits(const BezierPatch *patch, const Ray *ray, HitList *list, CurvedWork *work);

#endif
