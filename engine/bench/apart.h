// apart.h - work in a process of its own, so that its time and its memory can be told from all else.
#ifndef APP_APART_H
#define APP_APART_H

#include <stddef.h>

#include "engine/core/error.h"

// Zeroed memory that such a process and this one both see. Exits when there is none.
void *apart_memory(size_t size);
void apart_memory_free(void *memory, size_t size);

// Runs `work` in a copy of this process and waits for its end; what it leaves in shared memory is all that comes back.
// This process must not have run threads before: they would be missing in the copy. `what` is for messages.
bool apart_run(void (*work)(void *context), void *context, const char *what, Error *error);

// What this process used so far.
typedef struct ApartUsage {
    double cpu_seconds;  // of all its threads
    double peak_mb;
} ApartUsage;
ApartUsage apart_usage(void);

#endif
