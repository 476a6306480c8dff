// memory.c - the C library's memory, counted by the sizes of the blocks that the library really hands out.
#include "engine/core/memory.h"

#include <fcntl.h>
#include <malloc.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include "engine/core/page_file.h"

static const size_t MEGABYTE = (size_t)1 << 20;

// A process has one memory, so the state of this file is global.
static atomic_size_t used, peak;
static atomic_long requests, failing;
static atomic_bool injected;
// Held by the thread that ends the program, which never releases it. Guards the variables below that are not atomic.
static pthread_mutex_t ending = PTHREAD_RECURSIVE_MUTEX_INITIALIZER_NP;
static MemoryEnd *ends;
static MemoryBudget budget = {.file = "", .base = SIZE_MAX, .most = SIZE_MAX};
static size_t bytes_read;  // since the budget was set
static const char *stage = "working";
static atomic_size_t allowed = SIZE_MAX, most = SIZE_MAX;  // bytes in use
static atomic_bool exceeded;                               // a request went beyond `allowed`
static size_t fence_base;  // bytes of data not counted here; 0: no fence stands
static struct rlimit unfenced;

// The system's figures for this process.
typedef struct Process {
    size_t data, resident_peak;  // bytes
    long threads;
} Process;

// The number after `key` in the text of /proc/self/status, 0 if the key is missing.
static size_t number_after(const char *text, const char *key) {
    const char *at = strstr(text, key);
    return at ? strtoul(at + strlen(key), NULL, 10) : 0;
}

// Requests no memory. False where the system does not give the figures.
static bool measure_process(Process *out) {
    char text[4096];
    int fd = open("/proc/self/status", O_RDONLY | O_CLOEXEC);
    ssize_t length = fd < 0 ? -1 : read(fd, text, sizeof text - 1);
    if (fd >= 0) close(fd);
    text[length > 0 ? length : 0] = 0;
    *out = (Process){number_after(text, "\nVmData:") * 1024, number_after(text, "\nVmHWM:") * 1024,
                     (long)number_after(text, "\nThreads:")};
    return out->data > 0 && out->threads > 0;
}

// ---- the end

void memory_hold_end(void) { pthread_mutex_lock(&ending); }
void memory_release_end(void) { pthread_mutex_unlock(&ending); }

// Does not flush while another thread writes to standard output, since that thread may never go on.
static void flush_output(void) {
    if (ftrylockfile(stdout) == 0) fflush_unlocked(stdout);
}

// Ends the program. The caller holds the end (memory_hold_end) and it is never released, so that other threads that also find no
// memory do not repeat the sentence.
static _Noreturn void end(const char *sentence) {
    char line[sizeof(Error) + 16];
    int length = snprintf(line, sizeof line, "enfilade: %s\n", sentence);
    for (const MemoryEnd *one = ends; one; one = one->next) one->undo(one->context);
    flush_output();
    // If the sentence cannot be written, there is nothing left to do about it.
    if (write(STDERR_FILENO, line, (size_t)length) != length) _exit(EXIT_FAILURE);
    _exit(EXIT_FAILURE);
}

static bool set_over(Error *error) {
    return error_set(error, "%s: %s takes more than %zu MB of memory (%s)", budget.file, stage,
                     atomic_load(&allowed) / MEGABYTE, budget.remedy);
}

static _Noreturn void end_over(void) {
    Error error;
    memory_hold_end();
    set_over(&error);
    end(error.text);
}

// Did the fence cause the lack of memory, and not the machine or a test? For a library's request (`bytes` 0) neither its size is
// known nor the memory that the library has freed since. Libraries grow a block by doubling it, so the process had at least a
// quarter of the limit in use.
static bool at_fence(size_t bytes) {
    Process now;
    if (fence_base == 0 || atomic_load(&injected) || !measure_process(&now)) return false;
    size_t limit = atomic_load(&most);
    return bytes > 0 ? now.data + bytes > fence_base + limit : now.resident_peak > limit / 4;
}

void memory_end(size_t bytes) {
    char sentence[80];
    memory_hold_end();
    if (at_fence(bytes)) end_over();
    snprintf(sentence, sizeof sentence, "no memory for %zu bytes", bytes);
    end(sentence);
}

void memory_end_saying(const char *sentence) {
    memory_hold_end();
    end(sentence);
}

void memory_end_library(const char *name) {
    char sentence[80];
    memory_hold_end();
    if (at_fence(0)) end_over();
    snprintf(sentence, sizeof sentence, "no memory for %s", name);
    end(sentence);
}

void memory_add_end(MemoryEnd *one) {
    memory_hold_end();
    one->next = ends;
    ends = one;
    memory_release_end();
}

void memory_remove_end(MemoryEnd *one) {
    memory_hold_end();
    MemoryEnd **at = &ends;
    while (*at && *at != one) at = &(*at)->next;
    if (*at) *at = one->next;
    memory_release_end();
}

// ---- budgets

static void move_fence(void) {
    struct rlimit limit = unfenced;
    size_t place = fence_base + atomic_load(&most);
    if (limit.rlim_cur == RLIM_INFINITY || limit.rlim_cur > place) limit.rlim_cur = place;
    setrlimit(RLIMIT_DATA, &limit);
}

static void raise_fence(void) {
// There is no fence under the address sanitizer, whose own memory is data too.
#ifndef __SANITIZE_ADDRESS__
    // Bytes that the fence leaves to libraries beyond the budget, for fragmented heaps.
    static const size_t SLACK = (size_t)32 << 20;
    Process now;
    // There is no fence for a process with several threads, whose stacks are data too.
    if (getrlimit(RLIMIT_DATA, &unfenced) != 0 || !measure_process(&now) || now.threads != 1 ||
        now.data <= memory_used())
        return;
    fence_base = now.data - memory_used() + SLACK;
    move_fence();
#endif
}

void memory_lower_fence(void) {
    memory_hold_end();
    if (fence_base) setrlimit(RLIMIT_DATA, &unfenced);
    fence_base = 0;
    memory_release_end();
}

static void allow(void) {
    size_t beyond = bytes_read > budget.covered ? bytes_read - budget.covered : 0;
    size_t bytes = budget.base + budget.per_byte * beyond;
    if (bytes > budget.most) bytes = budget.most;
    atomic_store(&allowed, bytes);
    atomic_store(&most, budget.gentle ? budget.most : bytes);
}

void memory_set_budget(const MemoryBudget *wanted) {
    memory_hold_end();
    memory_lower_fence();
    budget = wanted ? *wanted : (MemoryBudget){.file = "", .base = SIZE_MAX, .most = SIZE_MAX};
    bytes_read = 0;
    atomic_store(&exceeded, false);
    allow();
    if (budget.fence) raise_fence();
    memory_release_end();
}

size_t memory_granted(void) { return budget.granted; }

void memory_set_stage(const char *now) {
    memory_hold_end();
    stage = now;
    memory_release_end();
}

void memory_note_read(size_t bytes) {
    memory_hold_end();
    bytes_read += bytes;
    allow();
    if (fence_base) move_fence();
    memory_release_end();
}

bool memory_within(Error *error) {
    if (!atomic_load(&exceeded)) return true;
    memory_hold_end();
    set_over(error);
    memory_release_end();
    return false;
}

// ---- counting

size_t memory_used(void) { return atomic_load(&used); }
size_t memory_peak(void) { return atomic_load(&peak); }

long memory_fail_at(long nth) {
    atomic_store(&injected, false);
    atomic_store(&failing, nth);
    return atomic_exchange(&requests, 0);
}

// Counts a request; false if memory_fail_at lets this request fail.
static bool granted(void) {
    long nth = atomic_fetch_add_explicit(&requests, 1, memory_order_relaxed) + 1;
    if (nth != atomic_load_explicit(&failing, memory_order_relaxed)) return true;
    atomic_store(&injected, true);
    return false;
}

bool memory_fits(size_t bytes) {
    return memory_used() + bytes <= atomic_load_explicit(&allowed, memory_order_relaxed);
}

size_t memory_left(void) {
    size_t limit = atomic_load_explicit(&allowed, memory_order_relaxed), now = memory_used();
    return now < limit ? limit - now : 0;
}

bool memory_runs_short(void) {
    size_t limit = atomic_load_explicit(&allowed, memory_order_relaxed);
    return memory_used() > limit - limit / 8;
}

static bool affordable(size_t bytes) {
    if (memory_fits(bytes)) return true;
    atomic_store(&exceeded, true);
    return memory_used() + bytes <= atomic_load_explicit(&most, memory_order_relaxed);
}

static void count_bytes(size_t size) {
    size_t now = atomic_fetch_add_explicit(&used, size, memory_order_relaxed) + size;
    size_t highest = atomic_load_explicit(&peak, memory_order_relaxed);
    while (now > highest && !atomic_compare_exchange_weak(&peak, &highest, now)) continue;
}

static void uncount_bytes(size_t size) { atomic_fetch_sub_explicit(&used, size, memory_order_relaxed); }

static void *count(void *memory) {
    count_bytes(malloc_usable_size(memory));
    return memory;
}

// ---- memory in files

// The file of this thread, and pieces from which size on lie there: arenas take no smaller ones.
static _Thread_local PageFile *own_file;
static const size_t LEAST_IN_FILE = 32 * 1024;

PageFile *memory_use_file(PageFile *file) {
    PageFile *before = own_file;
    own_file = file;
    return before;
}

bool memory_in_file(void) { return own_file != NULL; }

static void *take_from_file(size_t bytes) {
    void *memory = granted() ? page_file_take(own_file, bytes) : NULL;
    if (!memory) memory_end(bytes);
    if (!page_file_asleep(own_file)) count_bytes(page_file_size(memory));
    return memory;
}

static void give_to_file(void *memory, PageFile *file) {
    if (!page_file_asleep(file)) uncount_bytes(page_file_size(memory));
    page_file_give(memory);
}

void memory_sleep(PageFile *file) {
    if (!page_file_asleep(file)) uncount_bytes(page_file_used(file));
    page_file_set_asleep(file, true);
}

void memory_wake(PageFile *file) {
    size_t bytes = page_file_used(file);
    if (!page_file_asleep(file)) return;
    if (!affordable(bytes)) end_over();
    page_file_set_asleep(file, false);
    count_bytes(bytes);
}

void memory_leave_file(PageFile *file) {
    if (!file) return;
    memory_sleep(file);
    page_file_free(file);
}

bool memory_much_resident(void) {
    char text[256];
    size_t whole, pages;
    int fd = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
    ssize_t length = fd < 0 ? -1 : read(fd, text, sizeof text - 1);
    if (fd >= 0) close(fd);
    text[length > 0 ? length : 0] = 0;
    return sscanf(text, "%zu %zu", &whole, &pages) != 2 ||
           pages >
               atomic_load_explicit(&allowed, memory_order_relaxed) / 8 * 3 / (size_t)sysconf(_SC_PAGESIZE);
}

// ---- requests

void *memory_new(size_t bytes) {
    if (!affordable(bytes)) end_over();
    if (own_file && bytes >= LEAST_IN_FILE) return take_from_file(bytes);
    void *memory = granted() ? malloc(bytes ? bytes : 1) : NULL;
    if (!memory) memory_end(bytes);
    return count(memory);
}

void *memory_new_zeroed(size_t bytes) {
    if (!affordable(bytes)) end_over();
    if (own_file && bytes >= LEAST_IN_FILE) return take_from_file(bytes);
    void *memory = granted() ? calloc(1, bytes ? bytes : 1) : NULL;
    if (!memory) memory_end(bytes);
    return count(memory);
}

void *memory_grow(void *old, size_t bytes) {
    PageFile *file = old ? page_file_of(old) : NULL;
    if (file) {
        size_t there = page_file_size(old);
        void *larger = memory_new(bytes);
        memcpy(larger, old, there < bytes ? there : bytes);
        give_to_file(old, file);
        return larger;
    }
    size_t before = malloc_usable_size(old);
    if (bytes > before && !affordable(bytes - before)) end_over();
    void *memory = granted() ? realloc(old, bytes ? bytes : 1) : NULL;
    if (!memory) memory_end(bytes);
    atomic_fetch_sub_explicit(&used, before, memory_order_relaxed);
    return count(memory);
}

void memory_free(void *memory) {
    PageFile *file = memory ? page_file_of(memory) : NULL;
    if (file) give_to_file(memory, file);
    if (!memory || file) return;
    uncount_bytes(malloc_usable_size(memory));
    free(memory);
}

void memory_expect_full(void *memory, size_t bytes) {
    static const uintptr_t LARGE_PAGE = (uintptr_t)2 << 20;
    uintptr_t from = ((uintptr_t)memory + LARGE_PAGE - 1) / LARGE_PAGE * LARGE_PAGE,
              to = ((uintptr_t)memory + bytes) / LARGE_PAGE * LARGE_PAGE;
    // A system without large pages refuses, and goes on with small ones.
    if (from < to) madvise((void *)from, to - from, MADV_HUGEPAGE);
}

void memory_return_freed(void) { malloc_trim(0); }

// Pieces from 1 MB on that went back, 16 MB that stayed, and a pool for each thread made bakes ask the system for 1.4 to 1.8 times as many
// pages, and take 4 to 8 % less memory. The system may need 8 microseconds for a page, in which other processes wait.
void memory_return_large(void) {
    mallopt(M_ARENA_MAX, 1);
    mallopt(M_MMAP_THRESHOLD, 4 << 20);
    mallopt(M_TRIM_THRESHOLD, 32 << 20);
}
