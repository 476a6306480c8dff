// view.h - makes the eye of a visibility query from a camera.
#ifndef WALK_VIEW_H
#define WALK_VIEW_H

#include "visibility/hidden/hidden.h"
#include "visibility/vis.h"

// The eye with the four side planes of the view, which all pass through it; points behind the eye lie outside them too.
Eye walk_eye(const Camera *camera);

#endif
