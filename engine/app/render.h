// render.h - a still of a building: its light found or baked, a picture drawn by rays and written.
#ifndef APP_RENDER_H
#define APP_RENDER_H

#include "engine/app/app.h"
#include "engine/stills/still.h"

typedef struct RenderArguments {
    const char *file, *map, *light, *out;
    const char *view;             // NULL: the first of the building, or where a walk begins
    bool from, towards, widened;  // `eye`, `look`, `fov` were given
    Vec3 eye, look;
    double fov;  // radians, horizontal
    int width, height;
    StillOptions still;
    bool direct_given;  // else `still.direct` is what fits the building
    bool json;
} RenderArguments;

int render(const RenderArguments *arguments);  // the exit code

#endif
