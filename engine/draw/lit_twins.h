// lit_twins.h - faces in one place that look the same way, of which light reaches but one.
#ifndef WALK_LIT_TWINS_H
#define WALK_LIT_TWINS_H

#include "radiosity/mesh/mesh.h"

// [face_count] Does a lower face lie in the same place, in part, and look the same way? Light is told by that one
// (radiosity/factors/view.h): this one is dark there.
bool *lit_twins(const Mesh *mesh, Arena *arena);

#endif
