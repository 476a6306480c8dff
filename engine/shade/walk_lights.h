// walk_lights.h - which lamps shine on which objects as long as no light was computed: those of the same room.
#ifndef WALK_LIGHTS_H
#define WALK_LIGHTS_H

#include "visibility/vis.h"

typedef struct WalkLamp {
    float position[3];  // metres, relative to the given origin
    float strength;
    float colour[3];  // the largest channel is 1
    float unused;
} WalkLamp;

typedef struct WalkLights {
    WalkLamp *lamps;  // [lamp_count] in the order of their regions
    int *region;      // [object_count] the region it is in, -1: none
    int *first;  // [region_count + 1] the lamps of region r are lamps[first[r]] .. lamps[first[r + 1] - 1]
    int lamp_count;
} WalkLights;

// Lamps are the building's lights in rooms, and polygons that emit and face a room (panels let into a ceiling).
WalkLights walk_lights(const CellGraph *graph, Vec3 origin, Arena *arena);

// The lamps that shine on an object: the first, and how many.
static inline int walk_lamps_of(const WalkLights *lights, int object, int *count) {
    int region = lights->region[object];
    *count = region < 0 ? 0 : lights->first[region + 1] - lights->first[region];
    return region < 0 ? 0 : lights->first[region];
}

// Does the object stand under the sky?
static inline bool walk_outdoors(const CellGraph *graph, const WalkLights *lights, int object) {
    int region = lights->region[object];
    return region >= 0 && graph->building->regions[region].kind == REGION_OUTDOORS;
}

#endif
