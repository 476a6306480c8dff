// render.h - a still of a building: its light found or baked, a picture drawn by rays and written.
#ifndef APP_RENDER_H
#define APP_RENDER_H

#include "engine/app/app.h"
#include "engine/stills/still.h"

typedef struct RenderArguments {
    // Its `light` is the file that was given, or NULL.
    SceneOptions load;
    const char *file, *out;
    // NULL: the first of the building, or where a walk begins.
    const char *view;
    // `eye`, `look`, `fov` were given.
    bool from, towards, widened;
    Vec3 eye, look;
    // Radians, horizontal.
    double fov;
    // Width and height, pixels.
    int size[2];
    StillOptions still;
    // Else `still.direct` is as fits the building.
    bool direct_given;
    bool json;
} RenderArguments;

int render(const RenderArguments *arguments);  // the exit code

#endif
