// app_light.h - the light that `enfilade bake` stored, for those who show a building.
#ifndef APP_APP_LIGHT_H
#define APP_APP_LIGHT_H

#include "engine/app/app.h"
#include "engine/walk/walk_light.h"

// Where a building's light is: `given`, or FILE with the suffix .rad in place of its own if there is such a file; NULL:
// nowhere.
const char *app_find_light(const char *file, const char *given, Arena *arena);
// Makes the mesh again that the file was baked on. The scene was loaded with lamps (AppOptions). Refuses a file that is
// damaged or of another building.
bool app_load_light(const char *path, const AppScene *scene, Arena *arena, WalkLight *out, Error *error);

#endif
