// proxy.h - coarse stand-ins for fine furniture: they hide, receive and shoot light in its place (fine_mesh.h lights the fine model
// from them).
#ifndef RADIOSITY_PROXY_H
#define RADIOSITY_PROXY_H

#include "visibility/vis.h"

// Metres: within it silhouettes stay as they are. Half an inch: the shadow of a lamp of that size is as wide, and an element is five
// to twenty times as long.
#define PROXY_TOLERANCE 0.0125

// Tolerances are multiples of this, metres.
#define PROXY_STEP 1e-6

// The most corners that one of their polygons has.
enum { PROXY_CORNERS = 12 };

// Objects whose polygons are finer than light is told apart have stand-ins for these polygons; what is large, emits, moves or is
// glass is as it was.
// Read only once they are made: any number of threads. They live in the arena of the call that made them.
typedef struct Proxies {
    double tolerance;   // metres
    Polygon *polygons;  // [polygon_count] by objects, convex, counter-clockwise from the front
    Vec3 *vertices;     // [vertex_count] all of them vertices of the model
    int *first;         // [graph->object_count + 1] of each object's polygons
    bool *replaced;     // [graph->polygon_count] seen, but not there for light
    CellGraph graph;    // the same, but for the squares that objects touch: stand-ins touch others
    int polygon_count, vertex_count;
    int object_count, replaced_count;  // with stand-ins; of polygons
} Proxies;

// `vertices` as for mesh_build. NULL where nothing is so fine, or with a tolerance of 0. The same however many threads.
const Proxies *proxies_find(const CellGraph *graph, const Vec3 *vertices, double tolerance, Arena *arena);

#endif
