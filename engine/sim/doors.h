// doors.h - how far each door is open, and doors that move: over time, never into a body nor into another door.
#ifndef WALK_DOORS_H
#define WALK_DOORS_H

#include "engine/sim/body.h"

enum { DOOR_FREE, DOOR_MEETS_BODY, DOOR_MEETS_DOOR };

// How far each door stands open, and where it goes. One thread's at a time; queries of other threads read a copy of `open`. The arrays
// live in the arena of doors_new, and the graph outlives them.
typedef struct Doors {
    const CellGraph *graph;
    float *open;    // [opening_count] 0 closed .. 1 wide open, as vis_query wants it; 1 for other openings
    float *wanted;  // [opening_count] where it is going
    unsigned char *halt;  // [opening_count] DOOR_FREE, or the obstacle of the door, which goes on without it
    int *near_first;      // [opening_count + 1] run i is the doors whose leaves may meet those of door i
    int *near;
} Doors;

// Doors as drawn.
Doors doors_new(const CellGraph *graph, Arena *arena);

// A door that leads somewhere.
bool doors_usable(const Doors *doors, int opening);
// Opens one that is, or goes to, less than half open; closes the others. False where there is nothing to open.
bool doors_toggle(Doors *doors, int opening);
// Puts it there at once, whatever is in the way.
void doors_set(Doors *doors, int opening, float share);

// Doors of a building that was read again stand as they did: a door is the earlier one at its place, else the nearest of its name
// that no other door has for its place. Doors that are neither stay as drawn.
void doors_keep(Doors *doors, const Doors *earlier);

// Moves all doors towards where they are wanted; a lift carries the body that stands on it. `body` may be NULL.
// Allocates nothing.
void doors_advance(Doors *doors, double seconds, Body *body);

// The usable door whose leaf or doorway a ray from the eye in `cell` meets first, nearer than any wall and than
// `reach` metres; -1 if none. `direction` has unit length.
int doors_looked_at(const Doors *doors, Vec3 eye, int cell, Vec3 direction, double reach);
#define DOORS_REACH 2.5

#endif
