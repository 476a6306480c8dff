// walk_window.h - a walk in a window, until it is closed.
#ifndef WALK_WINDOW_H
#define WALK_WINDOW_H

#include "engine/walk/session.h"

// `scale`: pixels to a point; 0: the screen's own. Fails when no window can be opened, when the building cannot be read, or when OpenGL
// fails on the way.
bool walk_window(const SessionOptions *session, const DisplayOptions *display, double scale,
                 const SessionLoader *loader, Arena *arena, Error *error);

#endif
