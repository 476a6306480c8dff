// lamp_faces.h - faces that emit the flux of the lights of a building, since radiosity has no point lights.
#ifndef MAPS_LAMP_FACES_H
#define MAPS_LAMP_FACES_H

#include "maps/building/building.h"

// Appends an object for each light that has no glowing polygons of its own:
// - A light in a lamp shines from a square of the light's size outside the lamp, since lampshades are drawn closed. The square
//   lies close beneath the lamp and faces down; where the light sits above the lamp's middle and there is room below the ceiling,
//   the square lies close above the lamp and faces up.
// - A light without a lamp shines from the six sides of a cube.
// - A light with a photometric file (Light.photometry) shines from level openings of the file's size: one close beneath the lamp for
//   the light that goes down, one close above for the light that goes up; above both where the lamp stands. Lamps of several lights
//   have them once, and what glows of such a lamp is put out. A side for which there is no room is left out with a note.
// The exitance is the flux over the area. Returns the number of objects added. The building's hash stays that of the file.
int lamp_faces_add(Arena *arena, Building *b);

#endif
