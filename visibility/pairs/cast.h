// cast.h - sightlines in bulk: a line that is followed from cell to cell proves that all cells on its way see each other.
#ifndef VISIBILITY_PAIRS_CAST_H
#define VISIBILITY_PAIRS_CAST_H

#include "visibility/pairs/rounds.h"

// An edge of a portal as a line in space (J. Pluecker, 1865): its direction, of unit length, counter-clockwise about the normal of the
// way, and its moment about the origin.
typedef struct CastEdge {
    Vec3 along, moment;
    double least;  // metres: a line passes inside by so much, see sight_passes; infinite where none may
} CastEdge;

// The portals of all ways as lines are tried against them. Read only once it is made: any number of threads.
struct Cast {
    const WayGraph *ways;
    CastEdge *edges;
    int *first;  // [way_count + 1] the edges of way w are edges[first[w]] ..
};

void cast_build(const WayGraph *ways, Arena *arena, Cast *out);

// One thread's memory for the cells along a line.
typedef struct CastPath {
    int *cells;  // [cell_count + 1]
    double
        *places;  // [cell_count + 1] where the line is inside each: multiples of its direction from its point
    int count, source;  // the place of the cell in the list from which the way leads
} CastPath;

CastPath cast_path(const WayGraph *ways, Arena *arena);

// Follows the line through `point` of the way's portal along `direction` both ways, as far as it passes portals by their margins.
// False when it does not even pass that portal. All cells on the path see each other.
bool cast_line(const Cast *cast, int way, Vec3 point, Vec3 direction, CastPath *path);

// Adds all pairs of cells on the path to the finding; but a path of two cells adds none, see prove_neighbours.
void cast_record(const CastPath *path, Vec3 point, Vec3 direction, Finding *finding);

// Casts random lines from all portals, the same on any number of threads, and takes all pairs that they prove.
void cast_from_portals(Rounds *rounds);

#endif
