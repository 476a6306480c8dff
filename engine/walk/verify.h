// verify.h - is anything visible lost? A frame drawn from the visible set alone against the same frame with nothing
// culled: no blending, no antialiasing, one draw order, and the same pixels.
#ifndef WALK_VERIFY_H
#define WALK_VERIFY_H

#include "engine/core/random.h"
#include "engine/draw/view.h"

typedef struct WalkVerify WalkVerify;

// Opens an off-screen OpenGL context. What is drawn are the objects of the graph.
WalkVerify *walk_verify_new(const CellGraph *graph, const StabForest *forest, Arena *arena, Error *error);
void walk_verify_free(WalkVerify *verify);  // NULL is allowed

typedef struct VerifyFrame {
    VisResult visible;                   // of the query, until the next frame
    double query_seconds, draw_seconds;  // draw: of the culled frame
    int mismatched_pixels;               // in the item buffers or the colour images
    int missing_polygons;                // distinct ones seen in the unculled frame and not in the draw list
    int missing;                         // one of them, or -1
} VerifyFrame;

// Opaque polygons are compared first, then, with these as background, glass drawn as if it were opaque.
// `door_open` as for vis_query.
bool walk_verify_frame(WalkVerify *verify, const Camera *camera, int cell, const float *door_open,
                       Culling culling, VerifyFrame *out, Error *error);

// [vertex_count] of the graph, with the leaves of doors as they stood in the last frame.
const Vec3 *walk_verify_vertices(const WalkVerify *verify);

// The culled image of the last frame, [height * width * 3] sRGB.
void walk_verify_image(const WalkVerify *verify, uint8_t *rgb);
// How many distinct polygons of an item buffer are not in the last frame's draw list. `missing` may be NULL.
int walk_verify_missing(WalkVerify *verify, const ItemBuffer *items, int *missing);

// The opaque polygons that a door state shows, in draw order: what other methods are given. With an eye, surfaces of
// cells that face away from it are left out: two may lie back to back, and the eye sees one. `list` [polygon_count].
int walk_opaque_polygons(const CellGraph *graph, const float *door_open, const Vec3 *eye, int *list);

// A random view to be verified: eyes anywhere in free space, in doorways, within millimetres of corners, on and beside
// portal planes, beside their corners, in the planes of door leaves, outdoors; doors open and closed at random.
typedef struct RandomView {
    Camera camera;
    int cell;
    const char *kind;  // which of these
    float *door_open;  // [opening_count]
} RandomView;
// `out->door_open` must have room. False when the graph has no place of the kind drawn: draw again.
bool walk_random_view(const CellGraph *graph, Random *random, int width, int height, RandomView *out);

#endif
