// page_file.c - pieces of whole pages among reserved addresses, and the gaps between them, both in order. A piece that leaves the process
// is written to the file at its own place, and mapped from there.
#include "engine/core/page_file.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

enum { MOST_FILES = 4096, PAGE = 4096 };
// Addresses that a file may fill, and by how much it grows at least, bytes.
static const size_t ADDRESSES = (size_t)1 << 36, STEP = (size_t)16 << 20;

// Pages from `first` to `end`, bytes from the base. `marked`: of a piece, it lies in the file; of a gap, it was written and is not zero.
typedef struct Span {
    size_t first, end;
    bool marked;
} Span;

typedef struct Spans {
    Span *items;
    int count, capacity;
} Spans;

struct PageFile {
    int fd;
    char *base;
    size_t size, used;   // addresses in use; bytes of pieces
    bool stale;          // it may hold bytes of pieces that are gone
    Spans pieces, gaps;  // in order; neighbouring gaps differ in `marked`
    atomic_bool asleep;
    pthread_mutex_t mutex;
};

// Files by their numbers: a reader needs no lock, since the place of a file that is gone stays empty until another takes it.
static _Atomic(PageFile *) files[MOST_FILES];
static atomic_int most_files;

// ---- files

static int open_unnamed(const char *folder) {
    char path[4096];
    int fd = open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
    if (fd >= 0) return fd;
    // Not all file systems know files without a name.
    if ((size_t)snprintf(path, sizeof path, "%s/pages-XXXXXX", folder) >= sizeof path) return -1;
    fd = mkostemp(path, O_CLOEXEC);
    if (fd >= 0) unlink(path);
    return fd;
}

static bool enter(PageFile *file) {
    for (int i = 0; i < MOST_FILES; i++) {
        PageFile *none = NULL;
        if (!atomic_compare_exchange_strong(&files[i], &none, file)) continue;
        int count = atomic_load(&most_files);
        while (count <= i && !atomic_compare_exchange_weak(&most_files, &count, i + 1)) continue;
        return true;
    }
    return false;
}

static void leave(const PageFile *file) {
    for (int i = 0; i < MOST_FILES; i++)
        if (atomic_load(&files[i]) == file) atomic_store(&files[i], NULL);
}

PageFile *page_file_new(const char *folder, Error *error) {
    PageFile *file = calloc(1, sizeof *file);
    int fd = open_unnamed(folder);
    char *base = mmap(NULL, ADDRESSES, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (file && fd >= 0 && base != MAP_FAILED) {
        file->fd = fd;
        file->base = base;
        pthread_mutex_init(&file->mutex, NULL);
        if (enter(file)) return file;
        pthread_mutex_destroy(&file->mutex);
    }
    error_set(error, "%s: no file can be made there for memory: %s", folder,
              fd < 0 ? strerror(errno) : "there are too many");
    if (fd >= 0) close(fd);
    if (base != MAP_FAILED) munmap(base, ADDRESSES);
    free(file);
    return NULL;
}

void page_file_free(PageFile *file) {
    if (!file) return;
    leave(file);
    munmap(file->base, ADDRESSES);
    close(file->fd);
    pthread_mutex_destroy(&file->mutex);
    free(file->pieces.items);
    free(file->gaps.items);
    free(file);
}

PageFile *page_file_of(const void *memory) {
    for (int i = 0, count = atomic_load(&most_files); i < count; i++) {
        PageFile *file = atomic_load(&files[i]);
        if (file && (uintptr_t)memory - (uintptr_t)file->base < ADDRESSES) return file;
    }
    return NULL;
}

size_t page_file_used(PageFile *file) {
    pthread_mutex_lock(&file->mutex);
    size_t used = file->used;
    pthread_mutex_unlock(&file->mutex);
    return used;
}

void page_file_set_asleep(PageFile *file, bool asleep) { atomic_store(&file->asleep, asleep); }
bool page_file_asleep(PageFile *file) { return atomic_load(&file->asleep); }

// ---- spans; from here on the mutex is held

// The number of the first span that does not begin before `first`.
static int place_of(const Spans *spans, size_t first) {
    int low = 0, high = spans->count;
    while (low < high) {
        int middle = (low + high) / 2;
        if (spans->items[middle].first < first)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static void remove_span(Spans *spans, int at) {
    spans->count--;
    memmove(spans->items + at, spans->items + at + 1, (size_t)(spans->count - at) * sizeof *spans->items);
}

// Returns its number, -1: there is no memory.
static int add_span(Spans *spans, Span span) {
    if (spans->count == spans->capacity) {
        int capacity = spans->capacity * 2 + 64;
        Span *larger = realloc(spans->items, (size_t)capacity * sizeof *larger);
        if (!larger) return -1;
        spans->items = larger;
        spans->capacity = capacity;
    }
    int at = place_of(spans, span.first);
    memmove(spans->items + at + 1, spans->items + at, (size_t)(spans->count - at) * sizeof *spans->items);
    spans->items[at] = span;
    spans->count++;
    return at;
}

// Joins a gap with the next one, if they are alike.
static void join_next(Spans *gaps, int at) {
    if (at < 0 || at + 1 >= gaps->count) return;
    Span *gap = &gaps->items[at];
    if (gap->end != gap[1].first || gap->marked != gap[1].marked) return;
    gap->end = gap[1].end;
    remove_span(gaps, at + 1);
}

static bool add_gap(Spans *gaps, Span gap) {
    int at = add_span(gaps, gap);
    join_next(gaps, at);
    join_next(gaps, at - 1);
    return at >= 0;
}

// The least gap that is large enough, -1: there is none.
static int find_gap(const Spans *gaps, size_t bytes) {
    int best = -1;
    size_t least = SIZE_MAX;
    for (int i = 0; i < gaps->count; i++) {
        size_t size = gaps->items[i].end - gaps->items[i].first;
        if (size < bytes || size >= least) continue;
        least = size;
        best = i;
    }
    return best;
}

// ---- pieces

// Ordinary memory, zero, in the place of what was there.
static bool map_memory(const PageFile *file, size_t first, size_t end) {
    return mmap(file->base + first, end - first, PROT_READ | PROT_WRITE,
                MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | MAP_FIXED, -1, 0) != MAP_FAILED;
}

static bool grow(PageFile *file, size_t bytes) {
    size_t more = bytes < STEP ? STEP : bytes;
    if (more > ADDRESSES - file->size || !map_memory(file, file->size, file->size + more)) return false;
    file->size += more;
    return add_gap(&file->gaps, (Span){file->size - more, file->size, false});
}

static void *take_pages(PageFile *file, size_t bytes) {
    int at = find_gap(&file->gaps, bytes);
    if (at < 0) {
        if (!grow(file, bytes)) return NULL;
        at = find_gap(&file->gaps, bytes);
    }
    Span *gap = &file->gaps.items[at];
    size_t first = gap->first;
    if (add_span(&file->pieces, (Span){first, first + bytes, false}) < 0) return NULL;
    if (gap->marked) memset(file->base + first, 0, bytes);
    gap->first += bytes;
    if (gap->first == gap->end) remove_span(&file->gaps, at);
    file->used += bytes;
    return file->base + first;
}

void *page_file_take(PageFile *file, size_t bytes) {
    if (bytes > ADDRESSES) return NULL;
    pthread_mutex_lock(&file->mutex);
    void *piece = take_pages(file, bytes < 1 ? PAGE : (bytes + PAGE - 1) / PAGE * PAGE);
    pthread_mutex_unlock(&file->mutex);
    return piece;
}

// The number of the piece that begins there.
static int piece_at(const PageFile *file, const void *memory) {
    return place_of(&file->pieces, (size_t)((const char *)memory - file->base));
}

size_t page_file_size(const void *memory) {
    PageFile *file = page_file_of(memory);
    pthread_mutex_lock(&file->mutex);
    const Span *piece = &file->pieces.items[piece_at(file, memory)];
    size_t bytes = piece->end - piece->first;
    pthread_mutex_unlock(&file->mutex);
    return bytes;
}

static void leave_disk(PageFile *file, size_t first, size_t end) {
    int mode = FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE;
    if (fallocate(file->fd, mode, (off_t)first, (off_t)(end - first)) != 0) file->stale = true;
}

void page_file_give(void *memory) {
    PageFile *file = page_file_of(memory);
    pthread_mutex_lock(&file->mutex);
    int at = piece_at(file, memory);
    Span piece = file->pieces.items[at];
    remove_span(&file->pieces, at);
    file->used -= piece.end - piece.first;
    bool zero = piece.marked && map_memory(file, piece.first, piece.end);
    if (zero) leave_disk(file, piece.first, piece.end);
    // Pages that are still those of the file, and a gap that there is no memory to note, are lost until the file goes.
    if (zero || !piece.marked) add_gap(&file->gaps, (Span){piece.first, piece.end, !zero});
    pthread_mutex_unlock(&file->mutex);
}

// ---- out of the process

static bool write_all(int fd, const char *from, size_t bytes, size_t at) {
    while (bytes > 0) {
        ssize_t written = pwrite(fd, from, bytes, (off_t)at);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return false;
        from += written;
        at += (size_t)written;
        bytes -= (size_t)written;
    }
    return true;
}

// Pages whose state is asked for at a time; and the bits of those that hold anything: in memory, or swapped out (proc_pid_pagemap(5)).
enum { STATES = 512 };
static const uint64_t HELD = (uint64_t)3 << 62;

// Does each of `count` pages from an address on hold anything? Others were never touched, and are zero. -1 for `pagemap`: all may.
static void find_held(int pagemap, const char *from, size_t count, bool *held) {
    uint64_t state[STATES];
    off_t at = (off_t)((uintptr_t)from / PAGE * sizeof *state);
    bool known =
        pagemap >= 0 && pread(pagemap, state, count * sizeof *state, at) == (ssize_t)(count * sizeof *state);
    for (size_t i = 0; i < count; i++) held[i] = !known || (state[i] & HELD) != 0;
}

// Writes those pages of a piece of ordinary memory that were touched. Where the file was not written it is zero, unless it is stale.
static bool write_held(const PageFile *file, const Span *piece) {
    int pagemap = file->stale ? -1 : open("/proc/self/pagemap", O_RDONLY | O_CLOEXEC);
    const char *from = file->base + piece->first;
    bool held[STATES], good = true;
    size_t pages = (piece->end - piece->first) / PAGE, count;
    for (size_t first = 0; first < pages && good; first += count) {
        count = pages - first < STATES ? pages - first : STATES;
        find_held(pagemap, from + first * PAGE, count, held);
        for (size_t i = 0, end; i < count && good; i = end + 1) {
            for (end = i; end < count && held[end]; end++) continue;
            good = write_all(file->fd, from + (first + i) * PAGE, (end - i) * PAGE,
                             piece->first + (first + i) * PAGE);
        }
    }
    if (pagemap >= 0) close(pagemap);
    return good;
}

// Writes a piece to the file, and maps it from there.
static bool move_out(PageFile *file, Span *piece) {
    char *at = file->base + piece->first;
    size_t bytes = piece->end - piece->first;
    int reason = posix_fallocate(file->fd, (off_t)piece->first, (off_t)bytes);
    if (reason == 0 && !write_held(file, piece)) reason = errno;
    if (reason != 0) {
        leave_disk(file, piece->first, piece->end);
        errno = reason;
        return false;
    }
    piece->marked = mmap(at, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_FIXED, file->fd,
                         (off_t)piece->first) != MAP_FAILED;
    return piece->marked;
}

bool page_file_drop(PageFile *file, Error *error) {
    bool good = true;
    pthread_mutex_lock(&file->mutex);
    for (int i = 0; i < file->pieces.count && good; i++) {
        Span *piece = &file->pieces.items[i];
        if (!piece->marked) good = move_out(file, piece);
    }
    // The pages of shared mappings stay those of the file, and gaps hold nothing: all can go at once. That is much faster than one by one,
    // since other threads are told once.
    if (good && madvise(file->base, file->size, MADV_DONTNEED) == 0) {
        for (int i = 0; i < file->gaps.count; i++) file->gaps.items[i].marked = false;
        for (int i = file->gaps.count - 2; i >= 0; i--) join_next(&file->gaps, i);
    }
    pthread_mutex_unlock(&file->mutex);
    if (!good) error_set(error, "the disk has no room for memory that waits: %s", strerror(errno));
    return good;
}
