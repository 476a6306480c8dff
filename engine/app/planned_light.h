// planned_light.h - from a scene to the light of its rooms on a working plane: mesh, lamps and sky, with and without other rooms.
#ifndef APP_PLANNED_LIGHT_H
#define APP_PLANNED_LIGHT_H

#include "engine/scene/bake_mesh.h"
#include "radiosity/planner/room_light.h"

// Skies under which a daylight factor is found.
enum { PLANNED_OVERCAST, PLANNED_UNIFORM, PLANNED_NO_SKY, PLANNED_SKIES };
extern const char *const PLANNED_SKY_NAMES[PLANNED_SKIES];

typedef struct PlannedOptions {
    BakeOptions bake;
    int sky;
    double plane;  // above the floors, metres
} PlannedOptions;
PlannedOptions planned_default_options(void);  // overcast, 0.85 m

enum { PLANNED_LAMPS, PLANNED_DAY, PLANNED_SOURCES };

// The light of one source on a mesh of its own, which is fine where that light changes.
typedef struct PlannedSource {
    bool there;  // something emits; or there is a sky, and one is asked for
    Mesh mesh;
    RoomLight light;
    RoomValues values;
} PlannedSource;

typedef struct PlannedLight {
    float *doors;  // [opening_count]
    RoomPlan plan;
    PlannedSource sources[PLANNED_SOURCES];
    // Time of meshes and light as `enfilade bake` makes them, and of all that is found beyond: on the clock, and of all threads.
    double bake_seconds, bake_work, seconds, work;
} PlannedLight;

// Refuses a building without rooms, without light, and one whose rooms are all too low. The caller ends it.
bool planned_light(const LoadedScene *scene, const PlannedOptions *options, const Progress *progress,
                   Arena *arena, PlannedLight *out, Error *error);
void planned_light_end(PlannedLight *light);

#endif
