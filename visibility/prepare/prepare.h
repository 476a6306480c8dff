// prepare.h - a building made ready for questions of visibility, in one call: cells, portals, the pairs of cells that may see each
// other, and stab trees (Teller and Sequin 1991), or the last two from a file that an earlier call left.
#ifndef VISIBILITY_PREPARE_H
#define VISIBILITY_PREPARE_H

#include "visibility/vis.h"

// How a building is prepared.
typedef struct VisPrepareOptions {
    VisOptions vis;
    // The building's cells, where they were made before, by vis_build_cells with the same options; NULL: they are made.
    const CellGraph *graph;
    // A .vis file of this building: read where it is there, else written; NULL: neither.
    const char *file;
    // Do not read `file`, make it anew.
    bool fresh;
    // Read `file`, but never write it.
    bool read_only;
} VisPrepareOptions;
VisPrepareOptions vis_prepare_default_options(void);  // no file

// A building ready for questions; it lives in the arena of the call.
typedef struct VisPrepared {
    CellGraph graph;
    StabForest forest;
    // The forest was read from the file, which holds it now, too.
    bool read;
    // The file holds the forest.
    bool kept;
    // Progress ended the search early: visible sets are larger than need be, never smaller.
    bool stopped;
    // Pairs of cells, both ways round, that are neither proven to see each other nor excluded.
    long long undecided;
    // Why the file could not be read, and why it could not be written; "": it could, or was not to be.
    Error not_read, not_kept;
} VisPrepared;

// Fails only where no cells can be made (vis_build_cells). Progress is told the stage "cells" once, when they are made.
bool vis_prepare(const Building *building, const VisPrepareOptions *options, const Progress *progress,
                 Arena *arena, VisPrepared *out, Error *error);

#endif
