// walk_renderer.h - draws frames of a building in one of several looks.
//
// Works in the current OpenGL 3.3 context, in which it was made: a window's or one off-screen. A frame takes these calls: pose, draw,
// perhaps wireframe, finish_scene, perhaps an overlay by the caller, then show or read. The state of OpenGL is not restored.
#ifndef WALK_RENDERER_H
#define WALK_RENDERER_H

#include "engine/draw/mirrors.h"
#include "engine/draw/walk_store.h"
#include "engine/lit/exposure.h"
#include "visibility/hidden/hidden.h"
#include "visibility/vis.h"

typedef enum WalkLook {
    WALK_FAST,   // light baked beforehand, one sample a pixel: for a window without a GPU
    WALK_FINE,   // lamps in the fragment shader, ambient occlusion by depths in view, four samples a pixel
    WALK_BAKED,  // light by radiosity, usually four samples a pixel; drawn as WALK_FAST until there is light
    WALK_LOOKS
} WalkLook;
extern const char *const WALK_LOOK_NAMES[WALK_LOOKS];

typedef struct WalkRenderer WalkRenderer;

// Bakes the light of WALK_FAST and uploads all polygons of the graph; of a large building it does so for objects as they are seen.
WalkRenderer *walk_renderer_new(const CellGraph *graph, Arena *arena, Error *error);
// With limits of one's own.
WalkRenderer *walk_renderer_new_limited(const CellGraph *graph, const WalkStoreLimits *limits, Arena *arena,
                                        Error *error);
// Uploads the light that was baked for this graph, once, for WALK_BAKED.
bool walk_renderer_light(WalkRenderer *renderer, const WalkLight *light, Arena *arena, Error *error);
// Light can also arrive while the building is shown: walk_renderer_expect takes the mesh of the light, then walk_renderer_take uploads
// each state in slices, about `bytes` bytes a call. True once a state is there whole: the picture then fades to it, and the caller keeps
// it until the next state is there. A state on another mesh takes the place of the one before at once, without a fade.
void walk_renderer_expect(WalkRenderer *renderer, LitMesh *mesh);
bool walk_renderer_take(WalkRenderer *renderer, const LitLight *light, size_t bytes);
// Before, once, where light on one mesh after another comes, none of more than so many vertices: buffers for one or two of them at a time
// are made here and used again, since OpenGL takes many frames' time to make large ones.
void walk_renderer_reserve(WalkRenderer *renderer, int vertices, int rooms);
// A state that is not to be shown yet is uploaded by walk_renderer_prepare, true once it is there, for walk_renderer_take to show at once.
// Or it is dropped, and so is a mesh whose first state was not taken.
bool walk_renderer_prepare(WalkRenderer *renderer, const LitLight *light, size_t bytes);
void walk_renderer_drop(WalkRenderer *renderer);
// Drops the light that is shown as well, and its mesh, which the caller may free.
void walk_renderer_darken(WalkRenderer *renderer);
void walk_renderer_fade(WalkRenderer *renderer, double seconds);  // advances the fade
bool walk_renderer_fading(const WalkRenderer *renderer);
const LitMesh *
walk_renderer_mesh(const WalkRenderer *renderer);  // the mesh that is shown or first expected, or NULL
const LitLight *
walk_renderer_lit(const WalkRenderer *renderer);  // the state that is shown, NULL: there is no light yet

// Whether WALK_BAKED is drawn with one sample a pixel from now on: in software, four samples take five times as long.
void walk_renderer_plain(WalkRenderer *renderer, bool plain);
// How WALK_BAKED is drawn from now on: radiosities times `exposure` (m^2/W), or `quantity` in false colours.
void walk_renderer_tone(WalkRenderer *renderer, double exposure, FalseColour quantity);
void walk_renderer_free(WalkRenderer *renderer);  // NULL is allowed

// Puts the leaves of doors where `door_open` has them, as for vis_query; before the first call all are wide open.
// Costs next to nothing when no door has moved since the last call.
void walk_renderer_pose(WalkRenderer *renderer, const float *door_open);

// After a frame: prepares a part of what may be seen from the cell `cell` of a large building (walk_mesh_ahead).
void walk_renderer_ahead(WalkRenderer *renderer, const StabForest *forest, int cell);

// For tests: what is in OpenGL's memory.
WalkStoreFigures walk_renderer_held(const WalkRenderer *renderer);

// The frames drawn from now on show these mirrors of the camera that they are drawn from (mirrors_look), which must stay valid. False
// colours show none.
void walk_renderer_mirrors(WalkRenderer *renderer, const MirrorView *views, int count);

// Draws these objects, each at most once, to the renderer's own frame, which is as large as the camera's. The caller leaves out objects
// that the door state hides. Allocates only when the size or the look is new.
bool walk_renderer_draw(WalkRenderer *renderer, const Camera *camera, const int *objects, int object_count,
                        WalkLook look, Error *error);
// Between draw and finish_scene: draws the edges of these objects' polygons as lines over the frame; nothing hides the lines.
// `colour`: sRGB and alpha, 0 .. 1.
bool walk_renderer_wireframe(WalkRenderer *renderer, const Camera *camera, const int *objects,
                             int object_count, const float colour[4], Error *error);
// Ends the scene and binds the final frame with its viewport (colour alone, one sample a pixel), so that an overlay may draw to it.
// Row 0 of the final frame is the top: window pixel (x, y down) is OpenGL's (x, y).
bool walk_renderer_finish_scene(WalkRenderer *renderer, Error *error);

// After finish_scene: copies the final frame, upright, to a framebuffer of `width` x `height` pixels (0 is the window's), scaling it
// where the sizes differ. Leaves that framebuffer bound.
void walk_renderer_show(WalkRenderer *renderer, unsigned framebuffer, int width, int height);
// After finish_scene: reads the final frame into `rgb` [height * width * 3], sRGB, rows from the top.
bool walk_renderer_read(WalkRenderer *renderer, uint8_t *rgb, Error *error);
void walk_renderer_finish(void);  // waits until all drawing is done: for timing

#endif
