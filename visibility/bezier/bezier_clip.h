// bezier_clip.h - rays against rational bicubic Bezier patches, by Bezier clipping; and other ways to find the hits, to measure it
// against.
#ifndef RAYS_BEZIER_CLIP_H
#define RAYS_BEZIER_CLIP_H

#include "maps/building/building.h"
#include "visibility/bezier/hit_list.h"

// A patch made ready for rays: cut into nearly flat pieces, in a tree of boxes.
typedef struct BezierPatch BezierPatch;
// `whole`: in one piece, as it is. Lives in the arena, and ends with it.
BezierPatch *bezier_patch_new(const Building *building, const CurvedShape *shape, bool whole, Arena *arena);
Box bezier_patch_box(const BezierPatch *patch);
// From corner to corner of the box of its control points, metres.
double bezier_patch_size(const BezierPatch *patch);
// The point at u, v of a patch in one piece.
Vec3 bezier_patch_at(const BezierPatch *whole, double u, double v);

void bezier_hits(const BezierPatch *patch, const Ray *ray, HitList *list, CurvedWork *work);

typedef struct BezierMethod {
    const char *name;
    bool whole;  // of bezier_patch_new
    bool slow;   // by a hundred times
    void (*hits)(const BezierPatch *patch, const Ray *ray, HitList *list, CurvedWork *work);
} BezierMethod;

extern const BezierMethod BEZIER_METHODS[];  // ended by one without a name

#endif
