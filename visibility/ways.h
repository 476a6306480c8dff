// ways.h - a cell graph as the methods in three dimensions want it: each portal twice, once for each direction.
#ifndef VISIBILITY_WAYS_H
#define VISIBILITY_WAYS_H

#include <string.h>

#include "visibility/vis.h"
#include "visibility/winding.h"

// The shape of a way, as searches take it. Way 2 p crosses portal p from its cell[0] to its cell[1], way 2 p + 1 (its reverse,
// way ^ 1) comes back.
typedef struct WayShape {
    int from, to;
    Facet facet;          // of the portal, normal into `to`
    const Vec3 *corners;  // [corner_count] counter-clockwise about the normal
    // The same as the rows of a winding: x, then y, then z, with the first corner's copies as far as whole blocks need them.
    const double *rows;
    int corner_count;
    bool coarse;    // the portal has more corners than a winding should: these are of a rectangle around it
    double radius;  // around the facet's middle
} WayShape;

// Ways in the order of WayGraph.list, number by number for four at a time: each array is [way_count + FOUR].
typedef struct WayRows {
    double *x, *y, *z, *radius;  // the ball around the portal
    double *nx, *ny, *nz, *d;    // its plane
    double *doubt;               // 0 where the plane is sure, else infinite
} WayRows;

// Coordinates are relative to the middle of the building, so that one far from the origin loses no digits twice.
typedef struct WayGraph {
    WayShape *ways;  // [way_count]
    int *first;      // [cell_count + 1] the ways out of cell c are list[first[c]] ..
    int *list;       // [way_count]
    int *to;         // [way_count + FOUR] the cells that those of `list` lead into
    WayRows rows;    // of `list`
    Box *boxes;      // [cell_count] of a cell's portals: whatever enters or leaves a cell does so within it
    Vec3 origin;     // the point that was subtracted
    double epsilon;  // metres: see WAY_EPSILON
    int cell_count, way_count, words;
    double scale;  // how much more work than for a file of 1 MB may be done: see ways_work
} WayGraph;

// An opening that lets lines through over less than this share of the building's size lets none through: wide above the rounding
// of coordinates (1e-16) and of the numbers computed from them (1e-13), far below any gap that is meant.
#define WAY_EPSILON 2.5e-10

// Searches count their work in about nanoseconds of one core, each step by its mean time: the same on every
// machine and on any number of threads. A stage may do `small` of it for a file of up to 1 MB; for larger ones more, by the square of
// their size, since so does the number of pairs that may see each other. Pairs that are open when it is spent count as visible.
static inline long long ways_work(const WayGraph *ways, double small) {
    return (long long)(small * ways->scale);
}

void ways_build(const CellGraph *graph, Arena *arena, WayGraph *out);
// Those of some portals, [portal_count], whose cells have other numbers: `place` [whole->cell_count]. Corners are shared with `whole`.
void ways_take(const WayGraph *whole, const int *portal, int portal_count, const int *place, int cell_count,
               Arena *arena, WayGraph *out);

// Marks in `row` [words] the cells that a flood through the way reaches in which each further portal must lie at least
// partly beyond the first one, and the first one before it; where that takes too long, all. `stack` [cell_count] is scratch. Returns the
// portals tried.
long long ways_flood(const WayGraph *graph, int way, uint64_t *row, int *stack);

// Is the portal a segment in plan: upright, with all its corners on the line between its ends, within `epsilon` metres?
bool way_is_segment(const CellGraph *graph, int way, double epsilon);

// Numbers in each of the rows of a way.
static inline int way_row(int corner_count) { return (corner_count / FOUR + 1) * FOUR; }

static inline void way_winding(const WayShape *way, Winding *out) {
    int row = way_row(way->corner_count);
    const double *x = way->rows, *y = x + row, *z = y + row;
    out->facet = &way->facet;
    out->count = way->corner_count;
    for (int i = 0; i < row; i += FOUR) {
        four_store(out->x + i, four_load(x + i));
        four_store(out->y + i, four_load(y + i));
        four_store(out->z + i, four_load(z + i));
    }
}

// How far the plane of `way` may be off where `other` is, metres.
static inline double way_doubt(const WayShape *way, const WayShape *other) {
    return facet_doubt(&way->facet, other->facet.middle) + way->facet.tilt * other->radius;
}

static inline bool row_has(const uint64_t *row, int cell) { return row[cell / 64] >> (cell % 64) & 1; }
static inline void row_add(uint64_t *row, int cell) { row[cell / 64] |= (uint64_t)1 << (cell % 64); }
static inline void row_drop(uint64_t *row, int cell) { row[cell / 64] &= ~((uint64_t)1 << (cell % 64)); }
static inline void row_add_all(uint64_t *row, int cell_count) {
    for (int k = 0; k < cell_count / 64; k++) row[k] = UINT64_MAX;
    if (cell_count % 64) row[cell_count / 64] = ((uint64_t)1 << (cell_count % 64)) - 1;
}

#endif
