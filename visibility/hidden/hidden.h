// hidden.h - hidden-surface methods: which polygon is seen through each pixel, and how far away.
//
// A method is one file and one row in HIDDEN_METHODS.
#ifndef VISIBILITY_HIDDEN_H
#define VISIBILITY_HIDDEN_H

#include <stdint.h>

#include "engine/core/arena.h"
#include "engine/core/error.h"
#include "maps/building.h"

// A pinhole camera. Pixel (i, j) looks through x = (2(i + 0.5)/width - 1) * tan_x along `right`,
// y = (1 - 2(j + 0.5)/height) * tan_y along `up`, 1 along `forward`: row 0 is the top.
typedef struct Camera {
    Vec3 eye, forward, right, up;  // unit, orthogonal, right-handed: right x up = -forward
    double tan_x, tan_y;           // half the view's extent at distance 1
    int width, height;             // pixels
} Camera;

// Looks along yaw and pitch (see Viewpoint) with a horizontal field of view `fov`, radians.
Camera camera_look(Vec3 eye, double yaw, double pitch, double fov, int width, int height);
Vec3 camera_ray(const Camera *camera, double i,
                double j);  // through pixel coordinates; not normalised: forward part 1

// The polygons to draw, in order; of coincident surfaces the first in the list is seen. Polygons are seen from both
// sides.
typedef struct Scene {
    const Polygon *polygons;
    const Vec3 *vertices;
    const int *list;  // [count] indices of polygons; NULL: 0 .. count - 1
    int count;
} Scene;

typedef struct ItemBuffer {
    int width, height;
    int32_t *item;  // [height * width] polygon index, -1: nothing
    float *depth;   // [height * width] distance along `forward`, metres, INFINITY: nothing
} ItemBuffer;
ItemBuffer item_buffer_new(Arena *arena, int width, int height);

typedef struct HiddenMethod {
    const char *name;  // command line, CSV, test output
    const char *summary;
    // Prepares a scene; the result lives in the arena until `end`, if there is one.
    void *(*begin)(const Scene *scene, Arena *arena, Error *error);  // NULL on failure
    bool (*draw)(void *prepared, const Camera *camera, ItemBuffer *out, Error *error);
    void (*end)(void *prepared);  // may be NULL
} HiddenMethod;

extern const HiddenMethod *const HIDDEN_METHODS[];  // ends with NULL
const HiddenMethod *hidden_find(const char *name);  // NULL: no such method

#endif
