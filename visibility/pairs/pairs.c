// pairs.c - the table of cell-to-cell methods.
#include "visibility/pairs/pairs.h"

#include <string.h>

extern const PairMethod PAIR_METHOD_FLOOD, PAIR_METHOD_PLAN, PAIR_METHOD_HEIGHT, PAIR_METHOD_FLOW,
    PAIR_METHOD_PROOF;
const PairMethod *const PAIR_METHODS[] = {&PAIR_METHOD_FLOOD, &PAIR_METHOD_PLAN,  &PAIR_METHOD_HEIGHT,
                                          &PAIR_METHOD_FLOW,  &PAIR_METHOD_PROOF, NULL};

const PairMethod *pair_method(const char *name) {
    for (int i = 0; PAIR_METHODS[i]; i++) {
        if (strcmp(PAIR_METHODS[i]->name, name) == 0) return PAIR_METHODS[i];
    }
    return NULL;
}

const PairMethod *pair_method_finest(void) {
    int last = 0;
    while (PAIR_METHODS[last + 1]) last++;
    return PAIR_METHODS[last];
}
