// pairs_file.h - `.pairs` files: what a search for pairs of cells had found when it was stopped, so that another one can go on from there.
//
// A derived file (engine/core/file.h) under the hash of the cells and portals: the rows of PairSet.seen, then those of PairSet.proven.
#ifndef VISIBILITY_PAIRS_PAIRS_FILE_H
#define VISIBILITY_PAIRS_PAIRS_FILE_H

#include "visibility/pairs/pairs.h"

bool pairs_save(const char *path, const CellGraph *graph, const PairSet *set, Error *error);
// False, and a sentence, where the file is damaged or of other cells. The rows are `out`'s `seen` and `proven`.
bool pairs_load(const char *path, const CellGraph *graph, Arena *arena, PairSet *out, Error *error);

#endif
