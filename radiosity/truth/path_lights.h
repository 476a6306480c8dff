// path_lights.h - the faces that emit, chosen at random by how much light they may send to a point.
#ifndef RADIOSITY_PATH_LIGHTS_H
#define RADIOSITY_PATH_LIGHTS_H

#include "radiosity/truth/path_scene.h"

typedef struct PathLights PathLights;
// Points in the scene's coordinates.
PathLights *path_lights_new(const PathScene *scene, Arena *arena);

// A point before whose surface one asks for light.
typedef struct PathPlace {
    Vec3 point, normal;
} PathPlace;

typedef struct PathLightPoint {
    int face;
    Vec3 point;
    double density;  // of choosing it, 1/m^2
} PathLightPoint;
// `u` are in [0, 1). False: no light could reach the place by this choice.
bool path_lights_choose(const PathLights *lights, const PathPlace *place, const double u[3],
                        PathLightPoint *out);
// The density with which points of an emitting face are chosen, 1/m^2.
double path_lights_density(const PathLights *lights, const PathPlace *place, int face);

#endif
