// witness.h - does a sightline prove that two cells see each other? Walks it again through cells and portals alone, and
// shares nothing with the methods that find sightlines: a proof is worth as much as its check.
#ifndef VISIBILITY_PAIRS_WITNESS_H
#define VISIBILITY_PAIRS_WITNESS_H

#include "visibility/vis.h"

typedef struct WitnessWalk {
    bool proves;
    // Metres: how near the line comes to the edge of a portal it crosses, at least; INFINITY if to none
    double margin;
    double flattest;  // sine of the flattest angle at which it crosses one; 1 if it crosses none
    int crossed;      // portals
} WitnessWalk;

// A line that comes nearer to an edge than this share of the building's size, or of a hundred-thousandth of its distance
// from the origin where that is larger, proves nothing: it may owe its way to the rounding of coordinates.
#define WITNESS_MARGIN 1e-10
// Nor one that crosses a portal at a flatter angle (sine): the portals of a file bend by more.
#define WITNESS_FLATTEST 1e-6

// Follows the segment from its start, which must lie in cell a or on its boundary, out of each cell through the portal
// it pierces, until it is in b. It may end on the portal through which it enters b: a longer one would go on inside.
WitnessWalk witness_walk(const CellGraph *graph, int a, int b, Vec3 from, Vec3 to);

#endif
