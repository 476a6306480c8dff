// mesh_places.h - the points of a mesh, welded so that each place occurs once.
#ifndef RADIOSITY_MESH_PLACES_H
#define RADIOSITY_MESH_PLACES_H

#include "engine/core/arena.h"
#include "engine/core/vec.h"

// Points nearer to each other than this are one place, metres: above the rounding of georeferenced coordinates (1.5e-8 at
// MAPS_LIMIT), below the smallest distance of two sheets that are kept apart (2e-7).
#define MESH_WELD 1e-7

typedef struct Places {
    Arena *arena;
    Vec3 *points;  // [count]
    int count, capacity;
    struct PlaceLink *links;  // [count]
    int link_capacity;
    int *slots;  // [slot_count], a power of two: the last point added to each slot, -1: none
    int slot_count;
    int body;  // the body that points are added to: those of different bodies are never one place
} Places;

void places_start(Places *places, Arena *arena);
// The place of a point: the first place of the same body that was added within MESH_WELD of the point, else a new one.
int places_add(Places *places, Vec3 point);
// The body of a place.
int places_body(const Places *places, int place);

#endif
