// shoot_elements.h - the light that shots give to elements: a thread of its own adds it up, behind the one that chooses who shoots.
#ifndef RADIOSITY_SHOOT_ELEMENTS_H
#define RADIOSITY_SHOOT_ELEMENTS_H

#include "engine/core/lanes.h"
#include "radiosity/shoot/shoot_rows.h"

// Three channels lie in one register, whose fourth number is unused.
static inline Four channels_of(const double v[3]) { return (Four){v[0], v[1], v[2], 0}; }
static inline Four channels_of_floats(const float v[3]) {
    return (Four){(double)v[0], (double)v[1], (double)v[2], 0};
}
static inline void channels_store(Four from, double out[3]) {
    for (int c = 0; c < 3; c++) out[c] = from[c];
}

// Who shoots next depends on what patches have unshot, not on what elements shine with: that may come later, but shot after
// shot, as sums of doubles depend on their order.
typedef struct ShootElements ShootElements;

// Starts from the radiosities of `solution`; on one thread of `threads`, shots are told by the caller.
ShootElements *shoot_elements_new(const Mesh *mesh, const RadSolution *solution, int threads, Arena *arena);
// A patch shot `power`, W a channel. The row has to stay until it is told.
void shoot_elements_tell(ShootElements *e, const ShootRow *row, Four power);
// Returns when all shots are told.
void shoot_elements_finish(ShootElements *e);
// Into `radiosity` [element_count], W/m^2, when all shots are told.
void shoot_elements_store(const ShootElements *e, double (*radiosity)[3]);
void shoot_elements_end(ShootElements *e);

#endif
