// lit_states.h - the light that the baked look draws, in any state of the lamps. What a lamp gives is carried to what is drawn once.
#ifndef WALK_LIT_STATES_H
#define WALK_LIT_STATES_H

#include "engine/lit/lit_mesh.h"
#include "engine/scene/light.h"

typedef struct LitStates LitStates;

// `light` has `states` or a `follower`, and is drawn as `mesh`; both must outlive the result, which lives in the arena. Only one thread at
// a time may ask.
LitStates *lit_states_new(const LitMesh *mesh, const WalkLight *light, Arena *arena);
// Prepares what the first door asks for that moves, or one lamp more, a pass over all that is drawn; false: all is prepared, or progress
// asked to stop.
bool lit_states_prepare(LitStates *states, const Progress *progress);
// Is light with the doors, [opening_count], in such a state a sum?
bool lit_states_sums(const LitStates *states, const float *doors);
// The light with the lamps, [count of all lamps], and the doors, [opening_count], in another state. As long as the doors stand as they were
// baked, it is a sum, for which lamps that are not prepared are prepared; else it is found anew. False where progress asked to stop, or
// nobody knows this light.
//
// lit_states_fill_soon is the first step where light is to be found anew: false where it is a sum, or nothing is known soon.
bool lit_states_fill_soon(LitStates *states, const Rgb *lit, const float *doors, LitLight *out);
bool lit_states_fill(LitStates *states, const Rgb *lit, const float *doors, const Progress *progress,
                     LitLight *out);

#endif
