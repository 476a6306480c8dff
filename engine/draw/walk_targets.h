// walk_targets.h - the frames that the walk's renderer draws to, each made when it is first needed in a size: a window in the fast look
// never pays for the fine look's samples.
#ifndef WALK_TARGETS_H
#define WALK_TARGETS_H

#include <stdbool.h>

#include "engine/core/error.h"
#include "engine/draw/mirrors.h"

// Ambient occlusion is smooth: it is computed for every second pixel each way.
#define WALK_COARSE 2

typedef enum WalkTarget {
    WALK_TARGET_FINAL,      // colour alone: the frame that is shown and read
    WALK_TARGET_FAST,       // colour, a texture, and depth, one sample a pixel
    WALK_TARGET_FINE,       // colour and depth, several samples a pixel
    WALK_TARGET_DEPTH,      // depth alone, a texture
    WALK_TARGET_OCCLUSION,  // open share and distance, a texture, coarser
    WALK_TARGET_BLUR,       // the open share smoothed, a texture, as coarse
    WALK_TARGET_MIRROR,     // colour alone, a texture: what is seen in the first mirror; the others follow
    WALK_TARGETS = WALK_TARGET_MIRROR + MIRRORS_SHOWN
} WalkTarget;

typedef struct WalkTargets {
    unsigned frame[WALK_TARGETS];    // framebuffer objects, 0: not made
    unsigned texture[WALK_TARGETS];  // of the targets that are textures
    unsigned fast_depth, fine_colour, fine_depth;
    int width, height;
} WalkTargets;

// All zeros are targets of which none is made.
void walk_targets_free(WalkTargets *targets);
// Drops the frames when the size has changed; they are made again when needed. False, with an error, for sizes that OpenGL has not.
bool walk_targets_resize(WalkTargets *targets, int width, int height, Error *error);
// Binds a frame for drawing, with its viewport; makes the frame first if there is none.
bool walk_targets_bind(WalkTargets *targets, WalkTarget which, Error *error);

#endif
