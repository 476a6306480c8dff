// parallel.h - loops over independent work on several threads, and in several processes.
#ifndef CORE_PARALLEL_H
#define CORE_PARALLEL_H

#include <stdbool.h>
#include <stddef.h>

#include "engine/core/arena.h"
#include "engine/core/file.h"

// The number of threads for a loop: `wanted`, or for 0 the number of cores on which this process may run; at most 256.
int parallel_threads(int wanted);

// Calls body(context, index, thread) once for each index in 0 .. count - 1, on up to `threads` threads, 0 <= thread < threads;
// which thread takes which index, and when, is not determined. Returns when all calls are done. Waiting threads sleep, so they take
// no time from other programs.
void parallel_for(int threads, int count, void (*body)(void *context, int index, int thread), void *context);

// ---- loops that processes share
//
// Processes that do the same work (team.h) call parallel_share and parallel_agree alike, in the same order. Each index is worked on in
// one of them: whoever has nothing to do takes the next few from a counter, and in the end all have the results of all. What is computed
// must not depend on where that is. Inside a body the process is alone: both functions do there as they do in one process.

typedef struct SharedLoop {
    int count;
    // As parallel_for has it; keeps its result where `pack` finds it.
    void (*body)(void *context, int index, int thread);
    // The result of an index as bytes, in the arena; and that of another process, to be kept as `body` would have kept it. Not called
    // where one process does all. One call at a time, in the thread that called parallel_share.
    Bytes (*pack)(void *context, int index, Arena *arena);
    void (*unpack)(void *context, int index, Bytes result);
    void *context;
} SharedLoop;

void parallel_share(int threads, const SharedLoop *loop);
// Is it true in all processes?
bool parallel_agree(bool value);
// Is this the process that writes what all of them have found?
bool parallel_is_first(void);

// How processes share loops; all but `count` and `own` are called by all of them alike.
typedef struct ParallelRanks {
    int count, own;
    // The first of the next `pieces` indices of the loop at hand that nobody has taken. At its beginning that is 0.
    int (*take)(int pieces);
    // Ends the loop at hand. Returns the bytes that each process brings, [count] in the arena.
    const Bytes *(*collect)(Bytes own, Arena *arena);
} ParallelRanks;
// NULL: this process is alone.
void parallel_set_ranks(const ParallelRanks *ranks);

#endif
