// bezier_clip.h - rays against rational bicubic Bezier patches, by Bezier clipping; and other ways to find the hits, to measure it
// against.
#ifndef RAYS_BEZIER_CLIP_H
#define RAYS_BEZIER_CLIP_H

#include "visibility/bezier/bezier_patch.h"
#include "visibility/bezier/hit_list.h"

void bezier_hits(const BezierPatch *patch, const Ray *ray, HitList *list, CurvedWork *work);

typedef struct BezierMethod {
    const char *name;
    bool whole;  // of bezier_patch_new
    bool slow;   // by a hundred times
    void (*hits)(const BezierPatch *patch, const Ray *ray, HitList *list, CurvedWork *work);
} BezierMethod;

extern const BezierMethod BEZIER_METHODS[];  // ended by one without a name

#endif
