// lamp_faces.h - faces that emit the flux of the lights of a building: radiosity knows no points of light.
#ifndef MAPS_LAMP_FACES_H
#define MAPS_LAMP_FACES_H

#include "maps/building/building.h"

// Appends an object for each light that has no glowing polygons of its own:
// - one in a lamp shines from a square of the light's size close beneath the lamp, downwards; from one close above it,
//   upwards, where it sits above the lamp's middle and there is room below the ceiling: lampshades are drawn closed;
// - one without a lamp shines from the six sides of a cube.
// Exitance is flux over area. Returns how many were added. The hash stays that of the file.
int lamp_faces_add(Arena *arena, Building *b);

#endif
