// lit_parts.h - the parts of a large building's light that a walk has read: they stay in memory while there is room, so that an eye which
// comes back waits for nothing.
#ifndef LIT_PARTS_H
#define LIT_PARTS_H

#include "engine/lit/lit_part.h"

typedef struct LitParts LitParts;

// How often a part was wanted, and how often that took its files; parts in memory now.
typedef struct LitPartsCount {
    long wanted, read;
    int kept;
} LitPartsCount;

// The most vertices that a part's mesh has, as files as drawn say; 0 where some are missing.
int lit_parts_most_vertices(const LightOfParts *parts);

// Holds no part. It lives in the arena, but for what lit_parts_free frees.
LitParts *lit_parts_new(const LightOfParts *parts, Arena *arena);
void lit_parts_free(LitParts *parts);  // NULL is allowed

// The light of a part and its mesh, which is as `out` is where it was last, unless it was dropped. Where the memory that may be used
// (memory.h) would be more than three quarters full, parts that were wanted longest ago are dropped first; not `held`, which somebody
// still shows (-1: nobody does). NULL and an error where the part cannot be read.
LitMesh *lit_parts_get(LitParts *parts, int part, int held, LitLight *out, Error *error);
LitPartsCount lit_parts_count(const LitParts *parts);

#endif
