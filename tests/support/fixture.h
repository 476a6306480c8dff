// fixture.h - buildings made in memory, for tests of what comes after the readers.
#ifndef TESTS_FIXTURE_H
#define TESTS_FIXTURE_H

#include "engine/core/random.h"
#include "visibility/vis.h"

// nx x ny rooms of 4 x 4 x 2.7 m with walls of 0.2 m; between neighbours mostly a passage or a door (split in two
// halves) at a random place; some rooms hold a pillar, all a box of furniture. With `storeys` 2, the same again
// above, with a shaft through the slab of one room.
Building *fixture_rooms(Arena *arena, Random *random, int nx, int ny, int storeys);
// All of that turned about the origin, radians, then moved: walls along the axes, and what lies about the origin, hide which
// coordinate is taken for which.
void fixture_place(Building *b, double turn, Vec3 by);

typedef struct Trace {
    int cells[256];    // crossed, in order
    int portals[256];  // portals[i] leads from cells[i] to cells[i + 1]
    int count;
    Vec3 hit;  // where the line leaves free space or meets a closed door
} Trace;

// Follows a straight line from `from` in `cell` by its exits alone: the oracle for what can be seen. Lines that run
// within 1e-6 m of an edge of a portal are given up (returns false): they are decided by rounding.
bool fixture_trace(const CellGraph *graph, int cell, Vec3 from, Vec3 direction, const float *door_open,
                   Trace *out);

// Is the way the line took a path of the tree of the cell it began in?
bool fixture_in_tree(const StabForest *forest, const Trace *trace);

Vec3 fixture_point(const CellGraph *graph, Random *random, int cell);  // inside the cell
Vec3 fixture_direction(Random *random);                                // uniform on the sphere

double fixture_region_area(const Building *building, const Region *region);  // of its outline, m^2
// The area of a prism's boundary that neither portals nor surfaces cover, m^2; below 0 where they overlap.
double fixture_uncovered(const CellGraph *graph, int cell);
int fixture_dents(const CellGraph *graph);  // corners where a cell bends inwards, by the exact sign alone

#endif
