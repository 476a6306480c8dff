// verify.h - is anything visible lost? Compares a frame drawn from the visible set alone with the same frame drawn without culling:
// without blending and antialiasing, and in one draw order, so that the pixels must be the same.
#ifndef WALK_VERIFY_H
#define WALK_VERIFY_H

#include "engine/core/random.h"
#include "engine/draw/mirrors.h"
#include "engine/draw/view.h"

// An eye this near a surface is in it to a rasteriser, which draws the surface edge-on, or through the near plane, metres: GL items do
// so within 1e-5.
#define VERIFY_IN_SURFACE 2e-5

typedef struct WalkVerify WalkVerify;

// Opens an off-screen OpenGL context. The frames show the objects of the graph.
WalkVerify *walk_verify_new(const CellGraph *graph, const StabForest *forest, Arena *arena, Error *error);
void walk_verify_free(WalkVerify *verify);  // NULL is allowed

typedef struct VerifyFrame {
    VisResult visible;                   // result of the query, valid until the next frame
    double query_seconds, draw_seconds;  // draw: of the culled frame
    int mismatched_pixels;               // in the item buffers or the colour images
    int missing_polygons;                // polygons seen in the unculled frame that the draw list lacks
    int missing;                         // one of them, or -1
    int mirrors, mirror_pixels;  // what is seen in so many mirrors, at so many pixels, was compared, too
} VerifyFrame;

// First the opaque polygons are compared; then glass, drawn over them as if it were opaque; then the same in each mirror that the camera
// sees (at most MIRRORS_SHOWN), at the mirror's pixels but those at its borders, and without polygons that the image of the camera is in,
// behind the mirror. Its faults count with the others.
// `door_open` as for vis_query.
bool walk_verify_frame(WalkVerify *verify, const Camera *camera, int cell, const float *door_open,
                       Culling culling, VerifyFrame *out, Error *error);

// [vertex_count] of the graph, with the leaves of doors as they stood in the last frame.
const Vec3 *walk_verify_vertices(const WalkVerify *verify);

// The polygons seen in the last frame drawn without culling, glass as if it were opaque; valid until the next frame.
const ItemBuffer *walk_verify_items(const WalkVerify *verify);

// The mirrors that the last frame's camera sees, and [view->camera.height * view->camera.width] the opaque polygons seen there without
// culling, -1 where the frame does not show the mirror or a border of it; valid until the next frame. Returns the number of mirrors.
int walk_verify_mirrors(const WalkVerify *verify, const MirrorView **views);
const int32_t *walk_verify_mirror_items(const WalkVerify *verify, int mirror);

// The culled image of the last frame, [height * width * 3] sRGB.
void walk_verify_image(const WalkVerify *verify, uint8_t *rgb);
// The number of polygons in an item buffer that the last frame's draw list lacks. `missing` gets one of them; it may be NULL.
int walk_verify_missing(WalkVerify *verify, const ItemBuffer *items, int *missing);

// Lists the opaque polygons that a door state shows, in draw order, for other methods. With an eye, surfaces of cells that face away
// from it are left out: of two that lie back to back, the eye sees one. `list` [polygon_count]. Returns how many.
int walk_opaque_polygons(const CellGraph *graph, const float *door_open, const Vec3 *eye, int *list);

// A random view to be verified: eyes anywhere in free space, in doorways, within millimetres of corners and walls, on and
// beside portal planes, beside their corners, in the planes of door leaves, outdoors; doors open and closed at random.
typedef struct RandomView {
    Camera camera;
    int cell;
    const char *kind;  // which of these kinds of place
    float *door_open;  // [opening_count]
} RandomView;
// `out->door_open` must have room. False when no place of the drawn kind was found in the graph: call again.
bool walk_random_view(const CellGraph *graph, Random *random, int width, int height, RandomView *out);

#endif
