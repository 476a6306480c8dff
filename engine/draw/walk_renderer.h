// walk_renderer.h - a building drawn to be looked at.
//
// Works in the current OpenGL 3.3 context, in which it was made, a window's or one off-screen. A frame is: pose, draw,
// perhaps lines, finish_scene, perhaps an overlay by the caller, then show or read. State of OpenGL is left as it falls.
#ifndef WALK_RENDERER_H
#define WALK_RENDERER_H

#include "engine/draw/exposure.h"
#include "visibility/hidden/hidden.h"
#include "visibility/vis.h"

typedef enum WalkLook {
    WALK_FAST,   // light baked beforehand, one sample a pixel: for a window without a GPU
    WALK_FINE,   // lamps in the fragment, ambient occlusion of what is in view, four samples a pixel
    WALK_BAKED,  // light by radiosity, usually four samples a pixel; drawn as WALK_FAST where there is none
    WALK_LOOKS
} WalkLook;
extern const char *const WALK_LOOK_NAMES[WALK_LOOKS];

typedef struct WalkRenderer WalkRenderer;

// Bakes the light and uploads all polygons of the graph, once.
WalkRenderer *walk_renderer_new(const CellGraph *graph, Arena *arena, Error *error);
// Uploads the light that was baked for this graph, once, for WALK_BAKED.
bool walk_renderer_light(WalkRenderer *renderer, const WalkLight *light, Arena *arena, Error *error);
// Or the light comes while one looks: first its mesh, then each state of it, a slice at each call, of about so many bytes.
// True once a state is all there: from then on it is faded to, and stays until the next one is.
void walk_renderer_expect(WalkRenderer *renderer, LitMesh *mesh, Arena *arena);
bool walk_renderer_take(WalkRenderer *renderer, const LitLight *light, size_t bytes);
void walk_renderer_fade(WalkRenderer *renderer, double seconds);  // time goes on
bool walk_renderer_fading(const WalkRenderer *renderer);
const LitMesh *walk_renderer_mesh(const WalkRenderer *renderer);  // what was expected, or NULL
const LitLight *
walk_renderer_lit(const WalkRenderer *renderer);  // what is shown, NULL: there is no light yet

// Whether WALK_BAKED makes do with one sample a pixel from now on: by software four take five times as long.
void walk_renderer_plain(WalkRenderer *renderer, bool plain);
// How WALK_BAKED is drawn from now on: radiosities times `exposure` (m^2/W), or as numbers.
void walk_renderer_tone(WalkRenderer *renderer, double exposure, FalseColour quantity);
void walk_renderer_free(WalkRenderer *renderer);  // NULL is allowed

// Puts the leaves of doors where `door_open` has them, as for vis_query; before the first call all are wide open.
// Costs next to nothing when nothing has moved since the last call.
void walk_renderer_pose(WalkRenderer *renderer, const float *door_open);

// Draws these objects, each at most once, to a frame of its own as large as the camera's. Objects whose door state hides
// them are the caller's to leave out. Allocates only when the size or the look is new.
bool walk_renderer_draw(WalkRenderer *renderer, const Camera *camera, const int *objects, int object_count,
                        WalkLook look, Error *error);
// Between draw and finish_scene: the edges of these objects' polygons as lines over the frame, hidden by nothing.
// `colour`: sRGB and alpha, 0 .. 1.
bool walk_renderer_wireframe(WalkRenderer *renderer, const Camera *camera, const int *objects,
                             int object_count, const float colour[4], Error *error);
// Ends the scene. The final frame, colour alone, one sample a pixel, is bound from here on with its viewport: an overlay
// may draw to it. Its row 0 is the top: window pixel (x, y down) is OpenGL's (x, y).
bool walk_renderer_finish_scene(WalkRenderer *renderer, Error *error);

// After finish_scene. Copies the final frame, upright, to a framebuffer of that size, 0 being the window's; scales it
// where the sizes differ. That framebuffer is left bound.
void walk_renderer_show(WalkRenderer *renderer, unsigned framebuffer, int width, int height);
// After finish_scene. The final frame, [height * width * 3] sRGB, rows from the top.
bool walk_renderer_read(WalkRenderer *renderer, uint8_t *rgb, Error *error);
void walk_renderer_finish(void);  // waits until all is drawn: for timing

#endif
