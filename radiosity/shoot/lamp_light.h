// lamp_light.h - the light of each lamp by itself, so that any state of the lamps is a sum. Light that a lamp hardly gives is left out.
#ifndef RADIOSITY_LAMP_LIGHT_H
#define RADIOSITY_LAMP_LIGHT_H

#include "engine/core/arena.h"
#include "maps/building/building.h"

// Places of a block: elements or nodes with neighbouring indices, which mostly lie on one face.
enum { LIGHT_BLOCK = 16 };

// Radiosities that are 0 in most places, W/m^2 a channel. A place has three numbers of 9 bits and an exponent of 5 bits: its channels are
// off by a thousandth of the greatest of them at most (as in OpenGL's format RGB9_E5).
typedef struct SparseLight {
    int count, block_count;          // of places; of blocks with light
    float greatest;                  // W/m^2, of all channels
    int *block;                      // [block_count] ascending: places block * LIGHT_BLOCK ..
    uint32_t (*value)[LIGHT_BLOCK];  // [block_count]
} SparseLight;

// The light of one source: a lamp fully lit, or the day with all lamps off. As in RadSolution, but `straight` is the light of nodes
// without `rest`.
typedef struct LampLight {
    SparseLight radiosity, direct, straight, rest;
    double emitted[3], absorbed[3], escaped[3];
} LampLight;

// Blocks in which no place has more than a `least` share of its `usual` light are left out, [count] each; `usual` NULL: those without
// light.
SparseLight sparse_light_new(double (*light)[3], double (*usual)[3], int count, double least, Arena *arena);
// Adds it, times a share a channel, to `out` [light->count].
void sparse_light_add(const SparseLight *light, const double share[3], double (*out)[3]);
// Memory, bytes.
size_t sparse_light_bytes(const SparseLight *light);

#endif
