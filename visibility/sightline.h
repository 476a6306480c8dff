// sightline.h - is there a line that crosses a sequence of portals, in plan?
#ifndef VISIBILITY_SIGHTLINE_H
#define VISIBILITY_SIGHTLINE_H

#include "engine/core/vec.h"

// The left and right ends of the portals crossed so far, and the two extreme lines that cross them all: the one
// turned furthest counter-clockwise, from a right end to a later left end, and the one turned furthest clockwise,
// from a left end to a later right end.
typedef struct Sightline {
    Vec2 *left, *right;  // [capacity], the caller's
    int count, capacity;
    int ccw_from, ccw_to;  // right[ccw_from] -> left[ccw_to]
    int cw_from, cw_to;    // left[cw_from] -> right[cw_to]
} Sightline;

// Appends a portal with its ends as seen when crossing it. Returns false, and leaves the sightline as it was, when
// no line crosses them all; touching an end counts as crossing between portals that follow each other through convex
// cells, and is left open where they lie anyhow. `undo` takes the state to restore when the portal is dropped again.
typedef struct SightlineUndo {
    int ccw_from, ccw_to, cw_from, cw_to;
} SightlineUndo;
bool sightline_push(Sightline *line, Vec2 left, Vec2 right, SightlineUndo *undo);
void sightline_pop(Sightline *line, const SightlineUndo *undo);

#endif
