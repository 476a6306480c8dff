// proxy.h - coarse stand-ins for fine furniture: the stand-ins hide, receive and shoot light in place of the fine polygons
// (fine_mesh.h lights the fine model from them).
#ifndef RADIOSITY_PROXY_H
#define RADIOSITY_PROXY_H

#include "visibility/vis.h"

// How far a stand-in may lie off the model, metres: silhouettes change by no more. It is half an inch; a lamp of this size blurs
// shadows by as much, and an element is five to twenty times as long.
#define PROXY_TOLERANCE 0.0125

// Tolerances are rounded to multiples of this, metres.
#define PROXY_STEP 1e-6

// The most corners of a stand-in's polygon.
enum { PROXY_CORNERS = 12 };

// The stand-ins of a model. Objects with many polygons that are too fine to show differences of light have stand-ins for these
// polygons. Polygons that are large, emit light, move or are glass have none.
// Any number of threads may read them once they are made. They live in the arena of the call that made them.
typedef struct Proxies {
    double tolerance;  // metres
    // [polygon_count] of the stand-ins, sorted by object, convex, counter-clockwise from the front
    Polygon *polygons;
    Vec3 *vertices;  // [vertex_count] each is also a vertex of the model
    int *first;      // [graph->object_count + 1] the first in `polygons` of each object
    // [graph->polygon_count] this polygon of the model has a stand-in: shown, but unseen by light
    bool *replaced;
    CellGraph graph;  // the model's graph, with the squares that objects touch found for the stand-ins
    int polygon_count, vertex_count;
    int object_count, replaced_count;  // objects that have stand-ins; polygons of the model that are replaced
} Proxies;

// NULL where no object has enough fine polygons, or the tolerance is 0. The number of threads does
// not change the result.
const Proxies *proxies_find(const CellGraph *graph, double tolerance, Arena *arena);

#endif
