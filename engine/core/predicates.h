// predicates.h - signs that decide, computed without rounding error.
#ifndef CORE_PREDICATES_H
#define CORE_PREDICATES_H

#include "engine/core/vec.h"

// +1 when c lies left of the directed line a -> b, -1 right of it, 0 exactly on it. The sign is exact for all
// finite coordinates whose products neither overflow nor underflow.
int orient2d(Vec2 a, Vec2 b, Vec2 c);

#endif
