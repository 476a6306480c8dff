// walk_programs.h - the programs of the walk's renderer, and the places of their uniforms.
#ifndef WALK_PROGRAMS_H
#define WALK_PROGRAMS_H

#include "engine/core/error.h"

// Nothing nearer than this is drawn, metres: it is less than a head's distance from any wall; depth, a float of 1 - near/z,
// is then good to a fifth of a millimetre at 10 m.
#define WALK_NEAR 0.05

typedef enum SceneShader {
    SCENE_THINGS,    // fast
    SCENE_SURFACES,  // fast
    SCENE_PANES,     // fast
    SCENE_DEPTH,     // fine
    SCENE_FINE,
    SCENE_FINE_PANES,
    SCENE_LINES,
    SCENE_MIRROR,  // what is seen in a mirror
    SCENE_SHADERS
} SceneShader;

// A program that draws the building, and the locations of its uniforms; -1 for uniforms that it lacks.
typedef struct SceneProgram {
    unsigned program;
    int clip, eye, size, colour, day, before, share;
} SceneProgram;

// Places of what tells the sky of baked light.
typedef enum SkyPlace {
    SKY_LIT,
    SKY_SUN,
    SKY_GROUND,
    SKY_OVERHEAD,
    SKY_GRADATION,
    SKY_INDICATRIX,
    SKY_SUN_SHINES,
    SKY_PLACES
} SkyPlace;

typedef struct SkyProgram {
    unsigned program;
    int forward, right, up, day, strength, start, lit[SKY_PLACES];
} SkyProgram;

// Elements in their light.
typedef struct LitLook {
    unsigned lit, numbers;  // programs
    unsigned pictured;      // of elements with pictures, 0: none has
    unsigned scale;         // the scale of false colours, a texture
} LitLook;

typedef struct WalkPrograms {
    SceneProgram scene[SCENE_SHADERS],
        pictured[SCENE_SHADERS];  // without and with pictures; some programs are 0
    SkyProgram sky, pictured_sky;
    LitLook lit;
    unsigned occlusion, blur;
    int occlusion_tangents;  // a uniform of `occlusion`
    int flags;               // of all that draw the building, as for walk_program
} WalkPrograms;

// `flags` as for walk_program: SHADER_MIRRORS of a building with mirrors, SHADER_PICTURES of one with pictures; with `sky` there is a
// picture of the sky. On failure walk_programs_free frees those that were made.
bool walk_programs_new(int flags, bool sky, WalkPrograms *out, Error *error);
void walk_programs_free(WalkPrograms *programs);

#endif
