// prt.h - portal files as a building, with the leaves of which their cells are made.
#ifndef MAPS_PRT_H
#define MAPS_PRT_H

#include "maps/building/reader.h"

// The leaves behind the cells of a portal file. Of PRT1 they are the cells themselves; PRT2 and PRT1-AM tell to which cell, a cluster of
// leaves whose details hide nothing, each belongs.
typedef struct PrtLeaves {
    int count;
    int *cell;  // [count] of each leaf
} PrtLeaves;

bool prt_read(const char *path, Bytes content, Arena *arena, Building *out, PrtLeaves *leaves, Error *error);

#endif
