// lamps.h - the lamps of a building, each with materials of its own: so each can be switched, dimmed and coloured by itself.
#ifndef RADIOSITY_LAMPS_H
#define RADIOSITY_LAMPS_H

#include "radiosity/mesh/mesh.h"

// Faces that are switched together: those of an object that emit; of an object of a soup those that lie together; panels of one material in
// the ceilings of a room.
typedef struct Lamp {
    const char *name;  // of its object; of panels that of their material
    int region;        // in which it shines; -1: none, or the building has no regions
    const char *room;  // the region's name, or its place; "": there is none
    Vec3 place;        // the middle of its faces
    int object;        // in the graph, of its first face
    double flux[3];    // when it is fully lit, W a channel
} Lamp;

typedef struct Lamps {
    const CellGraph *graph;
    Lamp *lamps;       // [count] in the order of their first polygons
    int *of_material;  // [building->material_count] -1: of no lamp
    int *of_polygon;   // [graph->polygon_count] -1: of no lamp
    int count;
} Lamps;

// Finds the lamps of a building, and gives each materials of its own, whose Material.full is their emission. `graph` is that of `b`.
void lamps_find(CellGraph *graph, Building *b, Arena *arena, Lamps *out);

// A state of the lamps is a share a channel, [count]: 0 off, 1 fully lit. It is that of the emissions of all materials of lamps, into
// `materials` [building->material_count].
void lamps_switch(const Lamps *lamps, const Rgb *lit, Material *materials);

// The mesh in a state of the lamps: a graph and a building of its own, all else is that of `mesh`. Both live in the arena.
Mesh lamps_mesh(const Lamps *lamps, const Mesh *mesh, const Rgb *lit, Arena *arena);

#endif
