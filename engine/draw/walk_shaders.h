// walk_shaders.h - the shaders of the walk's renderer.
#ifndef WALK_SHADERS_H
#define WALK_SHADERS_H

#include "engine/core/error.h"

extern const char WALK_FINE_VERTEX[], WALK_FINE_FRAGMENT[];  // polygons, lit in the fragment shader
extern const char WALK_DEPTH_FRAGMENT[];                     // depth alone
extern const char WALK_BAKED_VERTEX[],
    WALK_BAKED_FRAGMENT[];  // surfaces of cells, lit beforehand in a texture
extern const char WALK_THING_VERTEX[],
    WALK_THING_FRAGMENT[];                                 // other polygons, lit beforehand at their corners
extern const char WALK_PANE_FRAGMENT[];                    // glass, lit beforehand
extern const char WALK_LIT_VERTEX[], WALK_LIT_FRAGMENT[];  // elements in their light
extern const char WALK_FALSE_VERTEX[], WALK_FALSE_FRAGMENT[];  // elements in false colours
extern const char WALK_LINE_VERTEX[], WALK_LINE_FRAGMENT[];    // lines in one colour
extern const char WALK_MIRROR_FRAGMENT[];                      // what is seen in a mirror
extern const char WALK_SCREEN_VERTEX[];                        // one triangle over the whole frame
extern const char WALK_SKY_FRAGMENT[];
extern const char WALK_OCCLUSION_FRAGMENT[], WALK_BLUR_FRAGMENT[];

// How a program differs from its plain shaders.
enum {
    SHADER_PICTURES = 1,  // polygons have pictures
    SHADER_CUT_OUT = 2,   // transparent texels are dropped
    SHADER_MIRRORS =
        4  // only what lies before the uniform plane `mirror` is drawn, while GL_CLIP_DISTANCE0 is on
};
// A program of these shaders with a `#define` for each of the flags; 0 on failure.
unsigned walk_program(const char *vertex, const char *fragment, int flags, Error *error);

#endif
