// shoot_elements.h - the light that shots give to elements: a separate thread adds it up, behind the thread that chooses the
// patches that shoot.
#ifndef RADIOSITY_SHOOT_ELEMENTS_H
#define RADIOSITY_SHOOT_ELEMENTS_H

#include "engine/core/lanes.h"
#include "radiosity/shoot/shoot_rows.h"

// Three channels lie in one register, whose fourth number is unused.
static inline Four channels_of(const double v[3]) { return (Four){v[0], v[1], v[2], 0}; }
static inline Four channels_of_floats(const float v[3]) {
    return (Four){(double)v[0], (double)v[1], (double)v[2], 0};
}
static inline Four channels_of_rgb(Rgb v) { return (Four){(double)v.r, (double)v.g, (double)v.b, 0}; }
static inline void channels_store(Four from, double out[3]) {
    for (int c = 0; c < 3; c++) out[c] = from[c];
}

// Which patch shoots next depends on the unshot light of patches, not on the radiosities of elements. Radiosities may therefore be
// added up later, but in the order of the shots, because sums of doubles depend on their order.
typedef struct ShootElements ShootElements;

// Starts from the radiosities of `solution`. With `threads` 1 there is no separate thread: the caller's thread adds up the shots.
ShootElements *shoot_elements_new(const Mesh *mesh, const RadSolution *solution, int threads, Arena *arena);
// Adds a shot of `power`, W a channel, along a row, which must stay valid until shoot_elements_finish. `direct`: the power is emitted
// light.
void shoot_elements_tell(ShootElements *e, const ShootRow *row, Four power, bool direct);
// Returns when all shots are added up.
void shoot_elements_finish(ShootElements *e);
// Stores the radiosities of a solution, and those that are direct. Call shoot_elements_finish first.
void shoot_elements_store(const ShootElements *e, RadSolution *solution);
// Goes on from the radiosities of a solution. Call shoot_elements_finish first.
void shoot_elements_load(ShootElements *e, const RadSolution *solution);
void shoot_elements_end(ShootElements *e);

#endif
