// hidden.h - hidden-surface methods: which polygon is seen through each pixel, and how far away.
//
// A method is one file and one row in HIDDEN_METHODS. What they share: facets.h (what polygons there are), image.h (where
// they lie in a picture), spans.h (which pixels of a row are inside).
#ifndef VISIBILITY_HIDDEN_H
#define VISIBILITY_HIDDEN_H

#include <stdint.h>

#include "engine/core/arena.h"
#include "engine/core/camera.h"
#include "engine/core/error.h"
#include "maps/building/building.h"

// The polygons to draw, in order; of coincident surfaces the first in the list is seen. Polygons are seen from both
// sides. Any will do: without area they are not seen, bent or concave ones are cut into triangles, and one that crosses
// itself into polygons that cover the triangles of ear clipping.
// The arrays are the caller's, and outlive everything that was prepared from them.
typedef struct Scene {
    const Polygon *polygons;
    const Vec3 *vertices;
    const int *list;  // [count] indices of polygons; NULL: 0 .. count - 1
    int count;
} Scene;

// A picture: the polygon that is seen through each pixel, and its distance.
// One thread's while it is drawn; it lives in the arena of item_buffer_new.
typedef struct ItemBuffer {
    int width, height;
    int32_t *item;  // [height * width] polygon index, -1: nothing
    float *depth;   // [height * width] distance along `forward`, metres, INFINITY: nothing
} ItemBuffer;
// Not yet drawn.
ItemBuffer item_buffer_new(Arena *arena, int width, int height);

// The largest picture, pixels each way.
#define HIDDEN_LARGEST 16384

// The work that a picture took. Each method counts its own kinds of work; the other counts stay 0.
typedef struct HiddenWork {
    int64_t polygons;     // set up: at least in part before the eye and within the picture
    int64_t edges;        // taken up, row by row or piece by piece
    int64_t comparisons;  // of a polygon with another, or with an area
    int64_t splits;       // of polygons, or of areas
    int64_t pixels;       // written, again and again
    int64_t depth_tests;  // of a polygon at a pixel
    int64_t nodes;        // of a tree, or cells of a grid
    int64_t rays;
    int64_t undecided;  // pairs of polygons whose order nothing told
    size_t memory;      // held beside the scene and the item buffer, bytes
} HiddenWork;

// A method: a row of the table.
typedef struct HiddenMethod {
    const char *name;  // command line, CSV, test output
    const char *summary;
    // Prepares a scene; the result lives in the arena until `end`.
    void *(*begin)(const Scene *scene, Arena *arena, Error *error);  // NULL on failure
    // Adds to `work`. Call hidden_draw, which looks at what it is given.
    bool (*draw)(void *prepared, const Camera *camera, ItemBuffer *out, HiddenWork *work, Error *error);
    void (*end)(void *prepared);
    enum {
        HIDDEN_EXACT,  // the ray caster's picture but for rounding at edges (1e-6 of a pixel) and ties (1e-9 of the depth)
        HIDDEN_FLOAT,  // the same within the rounding of floats
        HIDDEN_GUESS   // wrong where its rule fails
    } truth;
} HiddenMethod;

extern const HiddenMethod *const HIDDEN_METHODS[];  // ends with NULL
const HiddenMethod *hidden_find(const char *name);  // NULL: no such method

// False, and a sentence, for a camera that is none and pictures too small or too large. `work` may be NULL; else it starts
// from zero.
bool hidden_draw(const HiddenMethod *method, void *prepared, const Camera *camera, ItemBuffer *out,
                 HiddenWork *work, Error *error);

#endif
