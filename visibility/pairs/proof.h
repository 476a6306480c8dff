// proof.h - the stages of the method `proof`, for pairs of a part of a building too.
#ifndef VISIBILITY_PAIRS_PROOF_H
#define VISIBILITY_PAIRS_PROOF_H

#include "visibility/pairs/rounds.h"

// Decides the pairs that are still open after rounds_start or rounds_agree, and ends the rounds. `reach`: floods within beams come
// first (rounds_reach); not needed where `might` holds no more than merged searches reach.
void proof_search(Rounds *rounds, bool reach);

#endif
