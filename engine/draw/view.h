// view.h - from a camera to the query's eye.
#ifndef WALK_VIEW_H
#define WALK_VIEW_H

#include "visibility/hidden/hidden.h"
#include "visibility/vis.h"

// The four side planes of the view, all through the eye; what is behind it lies outside them too.
Eye walk_eye(const Camera *camera);

#endif
