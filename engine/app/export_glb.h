// export_glb.h - a lit building as binary glTF 2.0, for Blender and browsers.
#ifndef APP_EXPORT_GLB_H
#define APP_EXPORT_GLB_H

#include "radiosity/shoot/shoot.h"

// Elements as triangles, each vertex in the light that leaves it times an exposure, which `extras` of the scene tell.
// Storeys, rooms and things are nodes under their names, leaves of doors turn about their hinges, viewpoints are cameras. The
// file appears whole or not at all.
bool export_glb(const char *path, const Mesh *mesh, const RadSolution *solution, const float *door_open,
                Error *error);

#endif
