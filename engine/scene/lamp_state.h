// lamp_state.h - which lamps are on, how bright and of what colour, as users say it.
#ifndef SCENE_LAMP_STATE_H
#define SCENE_LAMP_STATE_H

#include "radiosity/mesh/lamps.h"

// The brightest state of a lamp, times its full light.
#define LAMP_STATE_MOST 10

// Applies a sentence such as "off,Kitchen=on,3=40%,Desk lamp=0.5#ffd8a8" (state_parts.h) to a state `lit` [lamps->count]. Before each `=`
// stands a lamp's number from 1, a lamp's name, a room's name (its lamps) or `all`. After it stand `on`, `off`, a share of the full light
// (0 .. LAMP_STATE_MOST, or with % after it), a colour #rrggbb, or a share and a colour: the lamp's light becomes of that hue, with the
// flux of all channels together as it was. Fails with a sentence that names the part, what was found and what is allowed.
bool lamp_state_apply(const Lamps *lamps, const char *sentence, Rgb *lit, Error *error);

// A lamp's state in words of the same language, `size` bytes at most.
void lamp_state_describe(const Lamps *lamps, int lamp, Rgb lit, char *out, size_t size);

#endif
