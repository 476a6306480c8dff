// bezier_methods.h - other ways to find where a ray hits a patch, to measure Bezier clipping against.
#ifndef RAYS_BEZIER_METHODS_H
#define RAYS_BEZIER_METHODS_H

#include "visibility/bezier/bezier_patch.h"
#include "visibility/bezier/hit_list.h"

typedef struct BezierMethod {
    const char *name;
    bool whole;  // of bezier_patch_new
    bool slow;   // by a hundred times
    void (*hits)(const BezierPatch *patch, const Ray *ray, HitList *list, CurvedWork *work);
} BezierMethod;

extern const BezierMethod BEZIER_METHODS[];  // ended by one without a name

#endif
