// facets.h - the polygons of a scene as every method of our own takes them: planar, convex, with area.
#ifndef VISIBILITY_FACETS_H
#define VISIBILITY_FACETS_H

#include "visibility/hidden/hidden.h"

// Polygons of more corners are several facets.
enum { FACET_CORNERS = 32 };

// A polygon whose plane passes the eye nearer than this is seen edge-on, by no pixel: metres. Far above the
// rounding of coordinates (1e-15 of a building's size), far below the distance of any real sheet from an eye.
#define HIDDEN_EDGE_ON 1e-9

typedef struct Facet {
    int polygon, order;  // index in the scene's polygons, place in its list
    int first, count;    // in Facets.corners, counter-clockwise about n
    Vec3 n, centre;      // of its plane, building space
    double rounding;     // metres: of its coordinates, a few times over; never 0
} Facet;

typedef struct Facets {
    Facet *facets;  // [count] in order of the list
    Vec3 *corners;  // [corner_count]
    int count, corner_count;
    double rounding;  // the most of any facet
} Facets;

// False, and a sentence, for coordinates that are no numbers, or beyond MAPS_LIMIT.
bool facets_new(const Scene *scene, Arena *arena, Facets *out, Error *error);

// The facets as a scene of their own, for those who take scenes: polygon i is facet i.
Scene facets_scene(const Facets *facets, Arena *arena);

#endif
