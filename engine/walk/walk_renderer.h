// walk_renderer.h - a building drawn to be looked at: shaded, antialiased, glass blended.
//
// Works in the current OpenGL context, in which it was made: off-screen here, a window's later.
#ifndef WALK_RENDERER_H
#define WALK_RENDERER_H

#include "visibility/hidden/hidden.h"
#include "visibility/vis.h"

typedef struct WalkRenderer WalkRenderer;

// Uploads all polygons of the graph once.
WalkRenderer *walk_renderer_new(const CellGraph *graph, Arena *arena, Error *error);
void walk_renderer_free(WalkRenderer *renderer);  // NULL is allowed

// Draws these objects (increasing, as a query gives them) to its own frame. Allocates only when the size changes.
// Objects whose door state hides them are the caller's to leave out.
bool walk_renderer_draw(WalkRenderer *renderer, const Camera *camera, const int *objects, int object_count,
                        Error *error);
void walk_renderer_finish(void);  // waits until all is drawn: for timing
// The frame, [height * width * 3] sRGB, rows from the top.
bool walk_renderer_read(WalkRenderer *renderer, uint8_t *rgb, Error *error);

#endif
