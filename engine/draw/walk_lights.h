// walk_lights.h - which lamps shine on which objects, until there is real light: those of the same room.
#ifndef WALK_LIGHTS_H
#define WALK_LIGHTS_H

#include "visibility/vis.h"

typedef struct WalkLamp {
    float position[3];  // relative to the origin given
    float strength;
    float colour[3];  // the largest channel 1
    float unused;
} WalkLamp;

typedef struct WalkLights {
    WalkLamp *lamps;     // [lamp_count] by region
    int *region;         // [object_count] where it is, -1: in none
    int *first, *count;  // [object_count] a run of lamps
    int lamp_count;
} WalkLights;

// The lamps are the building's lights, and polygons that emit (panels let into a ceiling), where they face a room.
WalkLights walk_lights(const CellGraph *graph, Vec3 origin, Arena *arena);

// Under the sky.
static inline bool walk_outdoors(const CellGraph *graph, const WalkLights *lights, int object) {
    int region = lights->region[object];
    return region >= 0 && graph->building->regions[region].kind == REGION_OUTDOORS;
}

#endif
