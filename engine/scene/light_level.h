// light_level.h - how bright a lit building is as a whole: the level from which an eye adapts to a view.
#ifndef SCENE_LIGHT_LEVEL_H
#define SCENE_LIGHT_LEVEL_H

#include "radiosity/shoot/shoot.h"

// Sums over elements indoors, or by night anywhere, and outdoors by day. All zeros: of none.
typedef struct LightLevel {
    double weight[2], log[2];
} LightLevel;

// Does the element lie outdoors?
bool light_outdoors(const Mesh *mesh, int element);
// Adds elements that do not emit; of the mesh of a part its own.
void light_level_add(LightLevel *level, const Mesh *mesh, const RadSolution *solution);
// The logarithmic mean of light_luminous, W/m^2, weighted by area and root of light. By day it is far brighter outdoors: then it is that of
// the rooms, where there are any. 0: all is dark.
double light_level(const LightLevel *level);

#endif
