// sky_openings.h - where daylight comes in: the portals between cells indoors and outdoors, cut into pieces.
#ifndef RADIOSITY_SKY_OPENINGS_H
#define RADIOSITY_SKY_OPENINGS_H

#include "radiosity/factors/form_factor.h"

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

// Openings of more corners are not taken.
enum { SKY_CORNERS = 64 };

bool sky_is_outdoors(const CellGraph *graph, int cell);
SkyOpenings sky_openings(const CellGraph *graph, Arena *arena);

// Forgets (-1) faces behind another opening among those that samples see from the middle of a piece of an opening, inwards.
void sky_end_at_exits(const SkyOpenings *openings, const StabForest *forest, int opening, const View *view,
                      const FormFactorSamples *samples, int32_t *item);

#endif
