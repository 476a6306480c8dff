// view.h - from a camera to the query's eye, and which objects a door state shows.
#ifndef WALK_VIEW_H
#define WALK_VIEW_H

#include "visibility/hidden/hidden.h"
#include "visibility/vis.h"

// The four side planes of the view, all through the eye; what is behind it lies outside them too.
Eye walk_eye(const Camera *camera);

// `door_open` [opening_count] or NULL for all open.
bool walk_shown(const Object *object, const unsigned char *door_open);

#endif
