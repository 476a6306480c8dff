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
    WalkLamp *lamps;     // [lamp_count] in the order of their regions
    int *region;         // [object_count] the region it is in, -1: none
    int *first, *count;  // [object_count] the run of lamps of its region
    int lamp_count;
} WalkLights;

// Lamps are the building's lights in rooms, and polygons that emit and face a room (panels let into a ceiling).
WalkLights walk_lights(const CellGraph *graph, Vec3 origin, Arena *arena);

// Does the object stand under the sky?
static inline bool walk_outdoors(const CellGraph *graph, const WalkLights *lights, int object) {
    int region = lights->region[object];
    return region >= 0 && graph->building->regions[region].kind == REGION_OUTDOORS;
}

#endif
