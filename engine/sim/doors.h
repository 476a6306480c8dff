// doors.h - how far each door is open, and doors that move over time, but never into a body or into another door.
#ifndef WALK_DOORS_H
#define WALK_DOORS_H

#include "engine/sim/body.h"

enum { DOOR_FREE, DOOR_MEETS_BODY, DOOR_MEETS_DOOR };

// How far each door stands open, and the share to which it moves. Only one thread at a time may use a Doors; queries of other
// threads read a copy of `open`. The arrays live in the arena of doors_new, and the graph must outlive them.
typedef struct Doors {
    const CellGraph *graph;
    float *open;    // [opening_count] 0 closed .. 1 wide open, as vis_query wants it; 1 for other openings
    float *wanted;  // [opening_count] the share to which it moves
    unsigned char *halt;  // [opening_count] DOOR_FREE, or the obstacle for which the door waits
    int *near_first;      // [opening_count + 1] run i is the doors whose leaves may meet those of door i
    int *near;
    struct DoorPlaces *places;  // of all openings, each with its leaves wherever they stand
} Doors;

// Makes doors that stand as drawn.
Doors doors_new(const CellGraph *graph, Arena *arena);

// Is the opening a door that leads somewhere?
bool doors_usable(const Doors *doors, int opening);
// Opens a door that stands, or is moving to, less than half open; closes any other door. Returns false where there is no usable
// door.
bool doors_toggle(Doors *doors, int opening);
// Sets the door to this share at once, even if something is in the way.
void doors_set(Doors *doors, int opening, float share);

// Sets the doors of a building that was read again as they stood before. Each door takes the share of the earlier door at its place
// or, if there is none, of the nearest earlier door of its name at whose place there is no door now. Doors with neither stay as
// drawn.
void doors_keep(Doors *doors, const Doors *earlier);

// Moves all doors towards their wanted shares; a leaf that rises carries the body that stands on it. `body` may be NULL. Allocates
// nothing.
void doors_advance(Doors *doors, double seconds, Body *body);

// Does any door move? Doors that wait for their way to be free do not.
bool doors_move(const Doors *doors);

// The usable door whose leaf or doorway a ray from the eye in `cell` meets first, nearer than any wall and than
// `reach` metres; -1 if none. `direction` has unit length.
int doors_looked_at(const Doors *doors, Vec3 eye, int cell, Vec3 direction, double reach);
#define DOORS_REACH 2.5

#endif
