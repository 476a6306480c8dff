// occluder_sieve.h - occluders by the directions in which they are seen, so that few of them are asked what they hide of a polygon.
#ifndef RADIOSITY_OCCLUDER_SIEVE_H
#define RADIOSITY_OCCLUDER_SIEVE_H

#include "engine/core/arena.h"
#include "engine/core/vec.h"

typedef struct OccluderSieve OccluderSieve;

// For `most` occluders. Lives in the arena.
OccluderSieve *occluder_sieve_new(int most, Arena *arena);
// Forgets all occluders.
void occluder_sieve_clear(OccluderSieve *sieve);
// Adds the next occluder, a convex polygon seen from the origin: the first one is number 0.
void occluder_sieve_add(OccluderSieve *sieve, const Vec3 *polygon, int count);
// The numbers of all occluders that may hide a part of a convex polygon, ascending, `found` of them; others are in other directions. Valid
// until the next call.
const int *occluder_sieve_ask(OccluderSieve *sieve, const Vec3 *polygon, int count, int *found);

#endif
