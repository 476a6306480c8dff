// smooth.h - smooths the stairs of edges in a picture that has one sample a pixel.
#ifndef WALK_SMOOTH_H
#define WALK_SMOOTH_H

#include <stdint.h>

#include "engine/core/arena.h"

// Changes `pixels` [height * width] in place: four bytes each, of which the lowest three are colours as on the screen (blue, green, red).
// The outermost pixels stay as they are. Allocates only for a new size; zeros begin a smoother.
typedef struct Smoother {
    Arena arena;
    uint8_t *bright;         // [height * width] of each pixel
    uint32_t *changed, *to;  // [height * width] the pixels that change, and their new colours
    uint8_t *edge;           // [width] of a row
    int width, height;
} Smoother;
void smooth_edges(Smoother *smoother, uint32_t *pixels, int width, int height);
void smooth_free(Smoother *smoother);

#endif
