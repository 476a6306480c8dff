// query_fixture.h - lines from eyes, and what queries must hold of them.
#ifndef TESTS_QUERY_FIXTURE_H
#define TESTS_QUERY_FIXTURE_H

#include "tests/support/soup_fixture.h"
#include "tests/support/support.h"
#include "visibility/query/query.h"

typedef struct Made {
    Arena arena;
    const Building *building;
    CellGraph graph;
    StabForest forest;
    VisQuery *query;
    float *doors;  // [opening_count] or NULL: all open
} Made;

void query_check_make(Made *m, const Building *b, int max_nodes);

// An open plan: n x n squares of 2 m, of which a share is solid, with floors and ceilings of several heights. Four cells meet
// in most corners, and most ways lead round pillars.
Building *query_check_pillars(Arena *arena, Random *random, int n, double solid);

// The planes that bound a cell, pointing inwards.
int query_check_cell_planes(const CellGraph *g, int c, Plane *out);

bool query_check_lists(const VisResult *result, int cell);

// A convex mix of a portal's corners, at random on its edges too.
Vec3 query_check_in_portal(const CellGraph *g, const Portal *portal, Random *random);

// On a portal of a cell, or 1e-9 m before or behind it.
Vec3 query_check_at_portal(const CellGraph *g, int cell, Random *random);

// How far the point is outside the planes of a cell, metres; negative inside.
double query_check_outside(const CellGraph *g, int c, Vec3 p);

typedef struct Tally {
    long lines, cells, eyes;
    long everything;  // eyes for which all is drawn
    long begun;       // cells that the eye is not in, in which its view begins
    long shut;        // pairs of a cell and one that only closed doors hide from it
} Tally;

// All cells that lines from the eye enter are found, and none but those that the eye's cell may see.
void query_check_check_eye(Made *m, int cell, Vec3 position, Culling culling, bool given, Random *random,
                           Tally *tally);

// All cells are found that lines from the eye enter on from any cell in which its view begins, whatever lies between. `cell` -1: the
// eye is in none.
void query_check_look_from(Made *m, int cell, Vec3 position, Culling culling, Random *random, Tally *tally);

void query_check_check_eyes(Made *m, int eyes, bool given, Random *random, Tally *tally);

#endif
