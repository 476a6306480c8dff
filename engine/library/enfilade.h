// enfilade.h - buildings, visibility in them, and walking in them; enfilade_light.h has hidden surfaces and light.
//
// Read a building (maps.h) or make one in memory (sketch.h), prepare it (prepare.h: cells, portals, stab trees), ask for
// visible cells and objects (vis.h), move doors (doors.h) and a body that collides with walls, furniture and leaves (body.h).
//
// Lengths are metres, z is up, angles radians. A function that can fail returns false and one sentence in an Error; a result lies
// in the caller's Arena and is freed with it. Options come from a function `..._default_options`. Nothing here prints, and the only
// global state is a count of memory. Buildings may be worked on side by side, each by one thread at a time. A building, its cells
// and its stab trees are read-only once they are made: any number of threads may query them, each with a query, doors and a body of
// its own.
// The comment of each type that has memory or a state says who owns it and how long it lasts. All other types are plain values:
// they may be copied freely, and pointers in them lead to memory of the caller.
#ifndef ENFILADE_H
#define ENFILADE_H

#include "engine/sim/body.h"
#include "engine/sim/doors.h"
#include "maps/building/lamp_faces.h"
#include "maps/building/sketch.h"
#include "maps/maps.h"
#include "visibility/pairs/pairs.h"
#include "visibility/prepare/prepare.h"
#include "visibility/vis.h"

#endif
