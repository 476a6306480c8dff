// settle.h - the last word on pairs of cells that separating planes do not exclude and no easy sightline proves.
#ifndef VISIBILITY_PAIRS_SETTLE_H
#define VISIBILITY_PAIRS_SETTLE_H

#include "visibility/pairs/rounds.h"

// Each pair seen but not proven is excluded, proven, or left as it is.
void settle_pairs(Rounds *rounds);

#endif
