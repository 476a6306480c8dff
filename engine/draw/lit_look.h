// lit_look.h - the shaders of the baked look: light exposed for the screen, or as numbers in false colours.
#ifndef WALK_LIT_LOOK_H
#define WALK_LIT_LOOK_H

#include "engine/core/error.h"
#include "engine/core/vec.h"
#include "engine/draw/false_colour.h"

typedef struct LitLook {
    unsigned lit, numbers;  // programs
    unsigned scale;         // of false colours, a texture
} LitLook;

// The light to be seen.
typedef struct LitTone {
    double exposure;       // radiosities are multiplied by it, m^2/W
    FalseColour quantity;  // instead, if it is one
} LitTone;

bool lit_look_new(LitLook *out, Error *error);
void lit_look_free(LitLook *look);
// Everything drawn from here on is shaded so. `clip` [16] by columns; `eye` relative to the mesh's origin; `fade` as of
// walk_lit.h; `range` of the quantity.
void lit_look_use(const LitLook *look, const LitTone *tone, LightRange range, const float *clip, Vec3 eye,
                  double fade);

#endif
