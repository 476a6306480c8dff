// bsp29.h - as much of a Quake level file (BSP version 29) as a visibility compiler reads and writes: the leaves, and
// what each of them sees.
#ifndef BENCH_BSP29_H
#define BENCH_BSP29_H

#include "engine/core/file.h"

// A level of `cell_count` leaves and nothing else.
Bytes bsp29_make(int cell_count, Arena *arena);

// What the leaves of such a level see once it was compiled, as PairSet.seen. Refuses one without visibility.
bool bsp29_read_seen(const char *path, int cell_count, Arena *arena, uint64_t **rows, Error *error);

#endif
