// bezier_trim.h - which part of a patch its trims leave: inside their loops an odd number of times.
#ifndef RAYS_BEZIER_TRIM_H
#define RAYS_BEZIER_TRIM_H

#include "engine/core/arena.h"
#include "maps/building/curved.h"
#include "visibility/bezier/ray.h"

typedef struct Trim Trim;
Trim *trim_new(const CurvedTrim *curves, int count, Arena *arena);

bool trim_keeps(const Trim *trim, Vec2 at, CurvedWork *work);

enum { TRIM_KEPT, TRIM_CUT_OFF, TRIM_SOME_KEPT };
// Tells how much of a rectangle of parameters is kept. Some may be said to be kept where all or none is.
int trim_state(const Trim *trim, Vec2 low, Vec2 high);

#endif
