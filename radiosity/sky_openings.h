// sky_openings.h - where daylight comes in: the portals between cells indoors and outdoors, cut into pieces.
#ifndef RADIOSITY_SKY_OPENINGS_H
#define RADIOSITY_SKY_OPENINGS_H

#include "radiosity/mesh.h"

typedef struct SkyOpening {
    int inside, outside;   // cells
    Plane plane;           // n points inside
    const Vec3 *vertices;  // [count] in CellGraph.portal_vertices
    int count;
} SkyOpening;

typedef struct SkyPiece {
    int opening;
    Vec3 centre;
    double area;  // m^2
} SkyPiece;

typedef struct SkyOpenings {
    SkyOpening *openings;  // [count]
    SkyPiece *pieces;      // [piece_count] opening after opening
    int count, piece_count;
} SkyOpenings;

bool sky_is_outdoors(const CellGraph *graph, int cell);
SkyOpenings sky_openings(const CellGraph *graph, Arena *arena);

#endif
