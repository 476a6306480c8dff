// renderer.h - pictures of a building: the objects of a graph, shaded, by OpenGL 3.3 in whatever context is current.
#ifndef WALK_RENDERER_H
#define WALK_RENDERER_H

#include <stdint.h>

#include "visibility/hidden/hidden.h"
#include "visibility/vis.h"

typedef struct WalkRenderer WalkRenderer;

// Uploads all polygons once. Until a building is baked the light is a sketch: the sky outdoors, and indoors the lamps
// of the room a surface belongs to, without shadows.
WalkRenderer *walk_renderer_new(const CellGraph *graph, Arena *arena, Error *error);
void walk_renderer_free(WalkRenderer *renderer);  // what OpenGL holds; NULL is allowed

// Draws these objects (increasing), antialiased, glass last. Allocates nothing once the image has its size. `rgb`
// [height * width * 3] sRGB, rows from the top, or NULL: drawn, but not read back.
bool walk_renderer_draw(WalkRenderer *renderer, const Camera *camera, const int *objects, int count, uint8_t *rgb,
                        Error *error);

#endif
