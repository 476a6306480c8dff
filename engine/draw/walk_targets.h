// walk_targets.h - the frames that the walk's renderer draws to.
#ifndef WALK_TARGETS_H
#define WALK_TARGETS_H

#include <stdbool.h>

#include "engine/core/error.h"

// Each look draws to its own, made when first asked for in a size.
typedef enum WalkTarget {
    WALK_TARGET_FINAL,      // colour alone: what is shown and read
    WALK_TARGET_FAST,       // the same colour, with depth
    WALK_TARGET_FINE,       // colour and depth, several samples a pixel
    WALK_TARGET_DEPTH,      // depth alone, a texture
    WALK_TARGET_OCCLUSION,  // open share and distance, a texture, coarser
    WALK_TARGET_BLUR,       // the open share smoothed, a texture, as coarse
    WALK_TARGETS
} WalkTarget;

typedef struct WalkTargets {
    unsigned frame[WALK_TARGETS];    // framebuffer objects, 0: not made
    unsigned texture[WALK_TARGETS];  // of those with one
    unsigned fast_depth, fine_colour, fine_depth;
    int width, height;
} WalkTargets;

// Starts anew when the size is another one.
bool walk_targets_resize(WalkTargets *targets, int width, int height, Error *error);
// Binds a frame for drawing, with its viewport; makes it first where that is still to do.
bool walk_targets_bind(WalkTargets *targets, WalkTarget which, Error *error);
void walk_targets_free(WalkTargets *targets);

#endif
