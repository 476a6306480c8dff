// gl_items.h - polygons drawn into an item buffer by OpenGL, exact enough to be compared: positions relative to the
// eye, depth from each polygon's plane, no blending, no antialiasing.
//
// All functions work in the current context, in which the items were made.
#ifndef VISIBILITY_GL_ITEMS_H
#define VISIBILITY_GL_ITEMS_H

#include "visibility/hidden/hidden.h"

// Nearer than this nothing is drawn, metres: an eye that almost touches a wall must not look through it. Depth does
// not suffer, it is a float of 1/z.
#define GL_ITEMS_NEAR 1e-6
// Metres.
#define GL_ITEMS_REACH 2e-4

typedef struct GlItems GlItems;

// The polygons of `scene`, in its order. `colours`, if not NULL, holds an RGBA for every place in the list, and a
// colour image is drawn along. Where `one_sided` (for every place in the list, kept; or NULL) is set, the back of a
// polygon is not drawn. Returns NULL on failure.
GlItems *gl_items_new(const Scene *scene, const uint32_t *colours, const unsigned char *one_sided,
                      Arena *arena, Error *error);
void gl_items_free(GlItems *items);  // the objects that OpenGL holds

// The vertices of a run of the scene's list were changed by their owner; they must stay in one plane.
void gl_items_moved(GlItems *items, int first, int count);

// Clears the buffers and takes up the camera. If `before` is not NULL, the eye lies behind that plane, and of polygons that reach farther
// than GL_ITEMS_REACH before it that part is drawn. Allocates only when the size of the image changes (in OpenGL).
bool gl_items_look(GlItems *items, const Camera *camera, const Plane *before, Error *error);
// A run of the scene's list to be drawn by the next gl_items_draw; in increasing order.
void gl_items_add(GlItems *items, int first, int count);
bool gl_items_draw(GlItems *items, Error *error);
// Reads the picture drawn since gl_items_look. `colour` [height * width] RGBA, rows from the top, or NULL.
bool gl_items_read(GlItems *items, ItemBuffer *out, uint32_t *colour, Error *error);

#endif
