// vis_pairs.h - `enfilade vis` with a cell-to-cell method: the matrix of the cells that see each other.
#ifndef APP_VIS_PAIRS_H
#define APP_VIS_PAIRS_H

#include "engine/app/app.h"
#include "visibility/pairs/pairs.h"

typedef struct VisPairsArguments {
    const char *file;
    SceneOptions load;    // its threads are the method's
    const char *method;   // NULL: the finest
    const char *out;      // where the matrix goes, or NULL
    const char *against;  // a .seen file to compare with, or NULL
    double seconds;       // to stop after; 0: when done
    bool json;
} VisPairsArguments;

// Returns the exit code: APP_BAD_INPUT also where a pair of `against` is missed.
int vis_pairs(const VisPairsArguments *arguments);

#endif
