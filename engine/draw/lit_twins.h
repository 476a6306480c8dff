// lit_twins.h - finds faces that lie in one place and look the same way: light reaches only one of them.
#ifndef WALK_LIT_TWINS_H
#define WALK_LIT_TWINS_H

#include "radiosity/mesh/mesh.h"

// [face_count] For each face: does a face of a lower number lie in the same place, at least in part, and look the same way? Form factors
// give the light there to the lower face (radiosity/factors/view.h), and the other face stays dark.
bool *lit_twins(const Mesh *mesh, Arena *arena);

#endif
