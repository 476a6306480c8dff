// app_light.h - the light that `enfilade bake` stored, for those who show a building.
#ifndef APP_APP_LIGHT_H
#define APP_APP_LIGHT_H

#include "engine/app/app.h"
#include "engine/walk/light_thread.h"

// Where a building's light may be, the likeliest first: `given` alone, or else FILE with the suffix .rad in place of its own, and
// what `enfilade bake FILE` left in the user's cache; only files that are there. Returns how many.
enum { APP_LIGHTS = 2 };
int app_find_lights(const char *file, const char *map, const char *given, Arena *arena,
                    const char *out[APP_LIGHTS]);
// Where `enfilade bake` leaves the light of a building, one for each; NULL: there is no cache.
const char *app_light_place(const Building *building, Arena *arena);
// What a cache is asked to have room for before light is made, bytes: less than most buildings' light takes.
enum { APP_LIGHT_ROOM = 1 << 20 };
// Makes the mesh again that the file was baked on. The scene was loaded with lamps (AppOptions). Refuses a file that is
// damaged or of another building.
bool app_load_light(const char *path, const AppScene *scene, Arena *arena, WalkLight *out, Error *error);

// A building to be baked as `enfilade bake FILE` does by itself, to be stored where that stores it.
typedef struct AppBake {
    const AppScene *scene;   // loaded with lamps
    const char *file, *out;  // out: NULL where there is no place to store it
} AppBake;
// NULL where nothing emits light, or there is nothing that it could fall on.
AppBake *app_bake_new(const char *file, const AppScene *scene, Arena *arena);
bool app_bake(void *bake, const LightHooks *hooks, Arena *arena, WalkLight *out,
              Error *error);  // of LightBaker

#endif
