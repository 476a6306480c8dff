// walk_window.h - a walk in a window, until it is closed.
#ifndef WALK_WINDOW_H
#define WALK_WINDOW_H

#include "engine/walk/session.h"

typedef struct WindowOptions {
    SessionOptions session;
    DisplayOptions display;
    double scale;  // pixels to a point; 0: what the screen says
    const DisplayBackEnd *back_end;
} WindowOptions;
WindowOptions window_default_options(void);

// Fails when no window can be opened, when the building cannot be read, or when OpenGL fails on the way.
bool walk_window(const WindowOptions *options, const SessionLoader *loader, Arena *arena, Error *error);

#endif
