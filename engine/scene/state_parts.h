// state_parts.h - sentences of WHO=STATE parts, in which users say the states of lamps and doors.
#ifndef SCENE_STATE_PARTS_H
#define SCENE_STATE_PARTS_H

#include <stdbool.h>

#include "engine/core/error.h"

// Puts one part of a sentence into force. `place` is where it stands, for messages: the option, or FILE:LINE. Fails with a sentence.
typedef bool StatePart(void *context, const char *place, const char *who, const char *state, Error *error);

// Applies the parts of a sentence such as "off,Kitchen=on", which commas separate, from left to right. Before the last `=` of a part stands
// whom it means, "all" where there is no `=`, and after it the state; spaces around both are left out, and so are blank parts. "@FILE"
// reads a file instead, one such part a line; lines that begin with # are remarks. Fails where a part does, where it is too long, and
// where the file cannot be read. `option` is the one that the sentence was given to.
bool state_parts_apply(const char *option, const char *sentence, StatePart *apply, void *context,
                       Error *error);

#endif
