// memory.c - the C library's memory, counted by what it really hands out.
#include "engine/core/memory.h"

#include <malloc.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { ALIGNMENT = 64 };

// One memory a process: what is global here belongs to it.
static atomic_size_t used, peak;
static atomic_long requests, failing;
// Held by whoever ends the program, and never given back.
static pthread_mutex_t ending = PTHREAD_RECURSIVE_MUTEX_INITIALIZER_NP;
static MemoryEnd *ends;

// ---- the end

// Flushing may wait for whoever writes just now, who may never go on.
static void flush_output(void) {
    if (ftrylockfile(stdout) == 0) fflush_unlocked(stdout);
}

void memory_end(size_t bytes) {
    char sentence[80];
    int length = snprintf(sentence, sizeof sentence, "enfilade: no memory for %zu bytes\n", bytes);
    memory_hold_end();
    for (const MemoryEnd *end = ends; end; end = end->next) end->undo(end->context);
    flush_output();
    // Where nobody reads the sentence there is nothing left to do about it.
    if (write(STDERR_FILENO, sentence, (size_t)length) != length) _exit(EXIT_FAILURE);
    _exit(EXIT_FAILURE);
}

void memory_hold_end(void) { pthread_mutex_lock(&ending); }
void memory_release_end(void) { pthread_mutex_unlock(&ending); }

void memory_add_end(MemoryEnd *end) {
    memory_hold_end();
    end->next = ends;
    ends = end;
    memory_release_end();
}

void memory_remove_end(MemoryEnd *end) {
    memory_hold_end();
    MemoryEnd **at = &ends;
    while (*at && *at != end) at = &(*at)->next;
    if (*at) *at = end->next;
    memory_release_end();
}

// ---- counting

long memory_fail_at(long nth) {
    atomic_store(&failing, nth);
    return atomic_exchange(&requests, 0);
}

// Is there to be memory for this request?
static bool granted(void) {
    long nth = atomic_fetch_add_explicit(&requests, 1, memory_order_relaxed) + 1;
    return nth != atomic_load_explicit(&failing, memory_order_relaxed);
}

static void *count(void *memory) {
    size_t size = malloc_usable_size(memory);
    size_t now = atomic_fetch_add_explicit(&used, size, memory_order_relaxed) + size;
    size_t most = atomic_load_explicit(&peak, memory_order_relaxed);
    while (now > most && !atomic_compare_exchange_weak(&peak, &most, now)) continue;
    return memory;
}

static void uncount(void *memory) {
    atomic_fetch_sub_explicit(&used, malloc_usable_size(memory), memory_order_relaxed);
}

size_t memory_used(void) { return atomic_load(&used); }
size_t memory_peak(void) { return atomic_load(&peak); }

// ---- requests

void *memory_new(size_t bytes) {
    void *memory = granted() ? malloc(bytes ? bytes : 1) : NULL;
    if (!memory) memory_end(bytes);
    return count(memory);
}

void *memory_new_aligned(size_t bytes) {
    void *memory = granted() ? aligned_alloc(ALIGNMENT, bytes) : NULL;
    if (!memory) memory_end(bytes);
    return count(memory);
}

void *memory_grow(void *old, size_t bytes) {
    size_t before = malloc_usable_size(old);
    void *memory = granted() ? realloc(old, bytes ? bytes : 1) : NULL;
    if (!memory) memory_end(bytes);
    atomic_fetch_sub_explicit(&used, before, memory_order_relaxed);
    return count(memory);
}

void *memory_try(size_t bytes) {
    void *memory = granted() ? calloc(1, bytes ? bytes : 1) : NULL;
    return memory ? count(memory) : NULL;
}

void memory_free(void *memory) {
    if (!memory) return;
    uncount(memory);
    free(memory);
}
