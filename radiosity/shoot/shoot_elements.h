// shoot_elements.h - what shots give to elements: a thread of its own adds it up, behind the one that chooses who shoots.
#ifndef RADIOSITY_SHOOT_ELEMENTS_H
#define RADIOSITY_SHOOT_ELEMENTS_H

#include "radiosity/shoot/shoot_rows.h"

// Three channels and one unused: one register.
typedef double Channels __attribute__((vector_size(32)));

static inline Channels channels_of(const double v[3]) { return (Channels){v[0], v[1], v[2], 0}; }
static inline Channels channels_of_floats(const float v[3]) {
    return (Channels){(double)v[0], (double)v[1], (double)v[2], 0};
}
static inline Channels channels_spread(double x) { return (Channels){x, x, x, x}; }
static inline void channels_store(Channels from, double out[3]) {
    for (int c = 0; c < 3; c++) out[c] = from[c];
}

// Who shoots next depends on what patches have unshot, not on what elements shine with: that may come later, but shot after
// shot, as sums of doubles depend on their order.
typedef struct ShootElements ShootElements;

// Starts from the radiosities of `solution`; on one thread of `threads`, shots are told by the caller.
ShootElements *shoot_elements_new(const Mesh *mesh, const RadSolution *solution, int threads, Arena *arena);
// A patch shot `power`, W a channel. The row has to stay until it is told.
void shoot_elements_tell(ShootElements *e, const ShootRow *row, Channels power);
// Returns when all shots are told.
void shoot_elements_finish(ShootElements *e);
// Into `radiosity` [element_count], W/m^2, when all shots are told.
void shoot_elements_store(const ShootElements *e, double (*radiosity)[3]);
void shoot_elements_end(ShootElements *e);

#endif
