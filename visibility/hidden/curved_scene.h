// curved_scene.h - curved shapes for methods that know polygons alone: subdivided for a view, as the lecture does (T. Nishita,
// Hidden-surface removal: scan lines and depth buffers take curved primitives by subdivision; E. Catmull 1974).
#ifndef VISIBILITY_CURVED_SCENE_H
#define VISIBILITY_CURVED_SCENE_H

#include "visibility/hidden/hidden.h"

typedef struct CurvedScene {
    Scene scene;        // given polygons keep their indices; polygons of shapes follow
    int first_polygon;  // of those
    int *shape;         // [first_polygon + subdivided] in Building.shapes, -1: of none
    int subdivided;     // polygons made for this view
    // How far a silhouette may be from where it should, pixels: where the finest is not fine enough.
    double largest_off;
} CurvedScene;

// How far polygons may lie off a shape, pixels: a quarter is seen by no picture of one sample a pixel but for its edges' noise.
#define CURVED_SCENE_PIXELS 0.25

// `given` lists polygons of the building, by its indices, and may hold others behind them; it has `polygon_count` polygons and
// `vertex_count` vertices in all. Shapes of which it lists a polygon are replaced by others that lie within `pixels` of them as
// the camera sees them; those that are out of the picture stay as they are.
void curved_scene_new(const Building *building, const Scene *given, int polygon_count, int vertex_count,
                      const Camera *camera, double pixels, Arena *arena, CurvedScene *out);

#endif
