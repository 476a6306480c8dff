// seen_file.h - `.seen` files: a visibility matrix as those who compare compilers exchange it.
//
// A 32-bit number of cells n, then n rows of ceil(n / 8) bytes; bit j of row i, least significant first, tells that j is
// seen from i. Little-endian, nothing else.
#ifndef VISIBILITY_PAIRS_SEEN_FILE_H
#define VISIBILITY_PAIRS_SEEN_FILE_H

#include "engine/core/file.h"

// Rows as in PairSet.seen. Refuses a file of another number of cells, of another size, with bits beyond the last cell,
// or in which a cell does not see itself.
bool seen_read(const char *path, int cell_count, Arena *arena, uint64_t **rows, Error *error);
// The same from memory; `path` is for messages.
bool seen_parse(const char *path, Bytes content, int cell_count, Arena *arena, uint64_t **rows, Error *error);

bool seen_write(const char *path, const uint64_t *rows, int cell_count, Error *error);

#endif
