// vis_level.h - `enfilade vis MAP.bsp`: the visibility of a Quake or Quake II level, written into the level.
#ifndef APP_VIS_LEVEL_H
#define APP_VIS_LEVEL_H

#include "visibility/pairs/pairs.h"

typedef struct VisLevelArguments {
    const char *file, *out;  // both may be the same
    const char *
        portals;  // a portal file; "leaves": none is looked for; NULL: that beside the level, if there is one
    bool clear_water;
    const PairMethod *method;
    int threads;     // 0: all cores
    double seconds;  // to stop after; 0: when done
    const char *
        state;  // a .pairs file: taken up where it is there, written when stopped early, removed when done; NULL: none
    size_t memory;  // bytes, 0: what the machine has
    bool json;
} VisLevelArguments;

// Returns the exit code.
int vis_level(const VisLevelArguments *a);

#endif
