// mirrors.h - flat mirrors as portals onto the reflected building (D. Luebke & C. Georges, Portals and Mirrors: simple, fast evaluation
// of potentially visible sets, 1995): which mirrors a camera sees, and what is seen in each, one reflection deep.
//
// Polygons of one material in one plane are one mirror. What is seen in it is what the image of the camera behind it sees through it.
#ifndef WALK_MIRRORS_H
#define WALK_MIRRORS_H

#include "engine/core/camera.h"
#include "visibility/vis.h"

// Materials of a smaller mirror share are drawn as if they had none.
#define MIRROR_LEAST 0.2f
// A mirror of less area shows no picture, m^2: a facet of something round, or less than a shaving mirror. Nor does one whose area is
// less than its length times this, metres: the edge of a sheet.
#define MIRROR_SMALLEST 0.02
#define MIRROR_NARROWEST 0.05
// A mirror also shows things up to this far behind its plane, metres, so that no gap shows along walls that the mirror touches.
// Floats are good to it in a building a kilometre long.
#define MIRROR_SLACK 1e-4
// Mirrors shown at the same time: those that are largest in the picture. Others are drawn as if their share were 0.
enum { MIRRORS_SHOWN = 4 };

// May the building have mirrors?
bool mirrors_in(const Building *building);

// The mirrors of a building. One thread's at a time.
typedef struct Mirrors Mirrors;

// A mirror as a camera sees it.
typedef struct MirrorView {
    Camera camera;  // the image of the camera: left-handed, with the same pixels
    Plane before;   // what is seen lies on its positive side, but for the mirror's own polygons
    int left, top, right, bottom;  // all pixels of the mirror lie in [left, right) x [top, bottom)
    const int *polygons;           // [polygon_count] of the graph: the mirror's own that the camera is before
    int leaf;                      // with which they move, or -1
    const int *objects;            // [object_count] to draw, increasing
    const int *cells;  // [cell_count] that what is seen of the mirror touches: the view begins there
    int polygon_count, object_count, cell_count;
    float share;  // of the light that it reflects, MIRROR_LEAST .. 1
} MirrorView;

// NULL: the building has no mirrors. The result lives in the arena and holds memory of its own until mirrors_free.
Mirrors *mirrors_new(const CellGraph *graph, const StabForest *forest, Arena *arena);
void mirrors_free(Mirrors *mirrors);  // NULL is allowed

// The mirrors that the camera sees, the largest in the picture first: returns how many, at most MIRRORS_SHOWN, 0 for NULL. `visible` is
// what vis_query found for the camera by `culling`. Mirrors on leaves stand as `door_open` has them. What is seen in each is found by
// `culling`, too, but which mirrors are shown does not depend on it. `views` stays valid until the next call.
int mirrors_look(Mirrors *mirrors, const Camera *camera, const VisResult *visible, const float *door_open,
                 Culling culling, const MirrorView **views);

#endif
