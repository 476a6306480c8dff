// memory.h - all memory that the program itself requests is handed out, grown, given back and counted here, and lack of memory ends
// the program here. Any thread may call these functions.
//
// Lack of memory ends the program with one sentence on standard error, `enfilade: no memory for N bytes`, and exit status 1. The
// program ends at once, whatever other threads do, and no exit handlers of libraries run. Before it ends, MemoryEnds are undone,
// standard output is flushed, and a file that is just getting its name gets it (memory_hold_end).
#ifndef CORE_MEMORY_H
#define CORE_MEMORY_H

#include <stdbool.h>
#include <stddef.h>

#include "engine/core/error.h"

void *memory_new(size_t bytes);              // never NULL; not zeroed
void *memory_new_zeroed(size_t bytes);       // never NULL; large pieces come from the system, untouched
void *memory_grow(void *old, size_t bytes);  // as realloc, but never NULL
bool memory_fits(size_t bytes);              // is a request for `bytes` within the budget?
size_t memory_left(void);                    // bytes until the budget is used up
bool memory_runs_short(void);                // is more than 7/8 of the budget in use?
void memory_free(void *memory);              // NULL is allowed
// All of this memory, which comes from here and was not touched yet, will be written: the system may give it large pages, which are
// several times as quick to get and to find again. Memory that stays untouched in part would take more than without.
void memory_expect_full(void *memory, size_t bytes);
void memory_return_freed(void);  // to the system: what was freed in many small pieces lies between others
// From now on large pieces go back to the system when they are freed, so that meshes and their solutions, which are made and freed one
// after the other, never add up. Left to itself, the library would keep them once some were freed. Smaller ones are used again, by
// whatever thread.
void memory_return_large(void);
_Noreturn void memory_end(size_t bytes);  // ends the program: no memory for `bytes` bytes

// Ends the program with another sentence: there is no room for memory where it was to go.
_Noreturn void memory_end_saying(const char *sentence);

// Ends the program: the library of this name reports that it found no memory.
_Noreturn void memory_end_library(const char *name);

// ---- memory of somebody who waits for long

typedef struct PageFile PageFile;  // page_file.h
// Large pieces that this thread asks for from now on, and its loops on several threads (parallel.h), lie in this file; NULL: as ever.
// Returns the file before.
PageFile *memory_use_file(PageFile *file);
bool memory_in_file(void);  // does this thread use one?
// All that lies in the file counts no more as bytes in use until memory_wake, which ends the program where it finds no memory for that.
// Its pages leave the process by page_file_drop; those that are read meanwhile come back by themselves.
void memory_sleep(PageFile *file);
void memory_wake(PageFile *file);
void memory_leave_file(PageFile *file);  // frees it with all that lies there; NULL is allowed
// Does the process have pages of more than three eighths of the budget? True where the system does not tell.
bool memory_much_resident(void);

// Bytes in use now, and the most that were in use at any time. Memory that libraries request themselves is not counted.
size_t memory_used(void);
size_t memory_peak(void);

// ---- budgets

// The memory that work on a file may use. A request for more ends the program as lack of memory does, but with the sentence
// `FILE: STAGE takes more than N MB of memory (REMEDY)`.
typedef struct MemoryBudget {
    const char *file, *remedy;  // must last as long as the budget
    size_t base;                // bytes in use that are allowed
    // Each byte that is read from files from now on, after the first `covered` bytes, allows `per_byte` bytes more.
    size_t covered, per_byte;
    size_t most;     // bytes; never more than this is allowed
    size_t granted;  // bytes, by the user; the data that a short file may request grows with them; 0: none
    bool gentle;     // use beyond the allowed bytes fails memory_within; only beyond `most` the program ends
    bool fence;      // libraries may not take more either: for stages without threads
} MemoryBudget;

// Sets the budget of the whole program from now on; it is copied, but not its strings. NULL: no budget.
void memory_set_budget(const MemoryBudget *budget);
void memory_lower_fence(void);             // libraries may take any amount of memory again
void memory_set_stage(const char *stage);  // "making cells"; must last
void memory_note_read(size_t bytes);       // `bytes` were read from a file
size_t memory_granted(void);
// Has the work stayed within its budget so far? If not, sets the error. Callers that can give up ask this between their steps.
bool memory_within(Error *error);

// Between memory_hold_end and memory_release_end the program does not end for lack of memory: a thread that would end it waits.
// Callers hold the end while a file has a name that is not its own. The calls nest; request no memory in between.
void memory_hold_end(void);
void memory_release_end(void);

// A child process or its file that must be cleaned up if the program ends for lack of memory. The struct is the owner's and must
// last from memory_add_end to memory_remove_end. `undo` runs in any thread, under memory_hold_end, and must request no memory.
typedef struct MemoryEnd {
    void (*undo)(void *context);
    void *context;
    struct MemoryEnd *next;
} MemoryEnd;
void memory_add_end(MemoryEnd *end);
void memory_remove_end(MemoryEnd *end);

// For tests: the nth request from now on finds no memory (1: the next one; 0: every request finds memory). Returns the number of
// requests since the last call.
long memory_fail_at(long nth);

#endif
