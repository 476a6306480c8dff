// memory.h - all memory of our own comes from here: handed out, grown, given back and counted in one place, which also ends the
// program where there is no more. Any thread may ask.
//
// No memory is one sentence on standard error, `enfilade: no memory for N bytes`, and exit status 1. The program ends at once,
// whatever other threads do: no handlers of libraries run. Standard output is flushed, MemoryEnds are told, and a file that is
// just getting its name gets it first (memory_hold_end).
#ifndef CORE_MEMORY_H
#define CORE_MEMORY_H

#include <stdbool.h>
#include <stddef.h>

#include "engine/core/error.h"

void *memory_new(size_t bytes);          // never NULL; not zeroed
void *memory_new_aligned(size_t bytes);  // the same, aligned to 64 bytes, of which `bytes` is a multiple
void *memory_grow(void *old,
                  size_t bytes);  // as realloc, but never NULL; `old` is not from memory_new_aligned
void *memory_try(size_t bytes);   // zeroed; NULL where there is none, for callers with something better to do
bool memory_fits(size_t bytes);   // is a request for so many within the budget?
void memory_free(void *memory);   // NULL is allowed
_Noreturn void memory_end(size_t bytes);  // there is none for so many bytes: ends the program

_Noreturn void
memory_end_library(const char *name);  // the library of this name says that it has none: ends the program

// Bytes in use, and the most that were. Memory that libraries ask for themselves is not counted.
size_t memory_used(void);
size_t memory_peak(void);

// ---- budgets

// The memory that work on a file may use. A request for more ends the program as no memory does, but says
// `FILE: STAGE takes more than N MB of memory (REMEDY)`.
typedef struct MemoryBudget {
    const char *file, *remedy;  // they last as long as the budget
    size_t base;                // bytes in use that are allowed
    size_t covered,
        per_byte;  // and so many more for each byte that is read from files from now on, after the first `covered`
    size_t most;     // never more than this
    size_t granted;  // by the user: the data that a short file may request grows with it; 0: none was given
    bool gentle;     // more than is allowed is left to memory_within: the program ends beyond `most` only
    bool fence;      // libraries may not take more either: for stages without threads
} MemoryBudget;

// From now on this one, for the whole program, of which a copy is kept; NULL: none.
void memory_set_budget(const MemoryBudget *budget);
void memory_lower_fence(void);             // libraries may take any amount of memory again
void memory_set_stage(const char *stage);  // "making cells"; lasts
void memory_note_read(size_t bytes);       // from a file
size_t memory_granted(void);
// Has the work stayed within its budget so far? If not, the sentence. Asked between steps by whoever can give up.
bool memory_within(Error *error);

// Between the two the program does not end for lack of memory: another thread waits with it. For moments in which a file has a
// name that is not its own. They nest; take no memory in between.
void memory_hold_end(void);
void memory_release_end(void);

// A child process or its file, to be undone where the program ends for lack of memory. The owner's, listed from
// memory_add_end to memory_remove_end. `undo` runs in any thread, under the hold, and takes no memory.
typedef struct MemoryEnd {
    void (*undo)(void *context);
    void *context;
    struct MemoryEnd *next;
} MemoryEnd;
void memory_add_end(MemoryEnd *end);
void memory_remove_end(MemoryEnd *end);

// For tests: from now on the nth request, 1 the next one, finds no memory; 0: none does. Returns how many requests there were since
// the last call.
long memory_fail_at(long nth);

#endif
