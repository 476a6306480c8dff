// walk_window.h - a walk in a window, until it is closed.
#ifndef WALK_WINDOW_H
#define WALK_WINDOW_H

#include "engine/walk/session.h"

// Pixels to a point are `scale`, or where that is 0 the screen's own. Fails when no window can be opened, when the building cannot be
// read, or when OpenGL fails on the way.
bool walk_window(const SessionOptions *session, const DisplayOptions *display, double scale,
                 const SessionLoader *loader, Arena *arena, Error *error);

#endif
