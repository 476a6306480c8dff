// apart.h - measurements in a process of their own: peak memory is theirs, and no thread is left over from an earlier one.
#ifndef BENCH_APART_H
#define BENCH_APART_H

#include <stdbool.h>
#include <stddef.h>

#include "engine/core/error.h"

// Time and memory that this process used so far.
typedef struct ApartUsage {
    double cpu_seconds;  // of all its threads
    double peak_mb;
} ApartUsage;

ApartUsage apart_usage(void);
// Seconds of a time of the system.
struct timeval;
double apart_seconds(struct timeval t);

// Returns zeroed memory that this process and the one of apart_run both see. Exits when there is none.
void *apart_memory(size_t size);
void apart_memory_free(void *memory, size_t size);

// Runs `work` in a copy of this process and waits for its end; only results in shared memory come back. This process must
// not have run threads before: they would be missing in the copy. `what` is the name of the work in messages.
bool apart_run(void (*work)(void *context), void *context, const char *what, Error *error);

#endif
