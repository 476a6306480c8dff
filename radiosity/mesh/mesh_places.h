// mesh_places.h - points of a mesh, each place once, and which of them lie on an edge.
#ifndef RADIOSITY_MESH_PLACES_H
#define RADIOSITY_MESH_PLACES_H

#include "engine/core/arena.h"
#include "engine/core/vec.h"

// Points nearer than this are one place, metres: above the rounding of georeferenced coordinates (1.5e-8 at MAPS_LIMIT),
// below the distance at which two sheets are still told apart (2e-7).
#define MESH_WELD 1e-7

typedef struct Places {
    Arena *arena;
    Vec3 *points;
    int count, capacity;
    struct PlaceLink *links;  // [count]
    int link_capacity;
    int *slots;  // [slot_count] a power of two; the last point that came there, -1
    int slot_count;
} Places;

void places_start(Places *places, Arena *arena);
// The place of a point: the first that came within MESH_WELD of it.
int places_add(Places *places, Vec3 point);

#endif
