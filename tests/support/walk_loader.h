// walk_loader.h - how tests load a building to walk through: as `enfilade walk` does, to be lit as one walks.
#ifndef TESTS_WALK_LOADER_H
#define TESTS_WALK_LOADER_H

#include "engine/walk/session.h"

// For a SessionLoader, whose context it does not need.
bool walk_loader_lit(void *context, const char *path, Arena *arena, WalkScene *out, Error *error);

#endif
