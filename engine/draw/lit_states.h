// lit_states.h - the light that the baked look draws, in any state of the lamps. What a lamp gives is carried to what is drawn once.
#ifndef WALK_LIT_STATES_H
#define WALK_LIT_STATES_H

#include "engine/draw/lit_mesh.h"
#include "engine/scene/light.h"

typedef struct LitStates LitStates;

// `light` has `states`, and is drawn as `mesh`; both must outlive the result, which lives in the arena. Only one thread at a time may ask.
LitStates *lit_states_new(const LitMesh *mesh, const WalkLight *light, Arena *arena);
// Prepares one lamp more, a pass over all that is drawn; false: all are prepared.
bool lit_states_prepare(LitStates *states);
// The light in a state of the lamps, [count of all lamps]. Lamps that are not prepared are prepared.
void lit_states_fill(LitStates *states, const Rgb *lit, LitLight *out);

#endif
