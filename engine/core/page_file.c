// page_file.c - pieces of whole pages in a mapped file, and the gaps between them, in order of their places. The system writes pages to the
// disk where it needs their memory for others.
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

enum { MOST_FILES = 4096 };
// Before each piece lies its size.
enum { PAGE = 4096, HEAD = 64 };
// Addresses that a file may fill, and by how much it grows at least, bytes.
static const size_t ADDRESSES = (size_t)1 << 36, STEP = (size_t)16 << 20;

// Pages between pieces. Those of a hole are zero, and have no room on the disk.
typedef struct Gap {
    size_t first, end;  // bytes from the start of the file
    bool hole;
} Gap;

struct PageFile {
    int fd;
    char *base;
    size_t size, used;  // of the file; of its pieces
    Gap *gaps;          // [gap_count] in order; neighbours differ in `hole`
    int gap_count, gap_capacity;
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
    free(file->gaps);
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

// ---- gaps; the mutex is held

static void remove_gap(PageFile *file, int gap) {
    file->gap_count--;
    memmove(file->gaps + gap, file->gaps + gap + 1, (size_t)(file->gap_count - gap) * sizeof *file->gaps);
}

// Joins a gap with the next one, if they are alike.
static void join_next(PageFile *file, int gap) {
    if (gap < 0 || gap + 1 >= file->gap_count) return;
    Gap *g = &file->gaps[gap];
    if (g->end != g[1].first || g->hole != g[1].hole) return;
    g->end = g[1].end;
    remove_gap(file, gap + 1);
}

static bool add_gap(PageFile *file, Gap gap) {
    if (file->gap_count == file->gap_capacity) {
        int capacity = file->gap_capacity * 2 + 64;
        Gap *larger = realloc(file->gaps, (size_t)capacity * sizeof *larger);
        if (!larger) return false;
        file->gaps = larger;
        file->gap_capacity = capacity;
    }
    int at = file->gap_count;
    while (at > 0 && file->gaps[at - 1].first > gap.first) at--;
    memmove(file->gaps + at + 1, file->gaps + at, (size_t)(file->gap_count - at) * sizeof *file->gaps);
    file->gaps[at] = gap;
    file->gap_count++;
    join_next(file, at);
    join_next(file, at - 1);
    return true;
}

// The least gap that is large enough, -1: there is none.
static int find_gap(const PageFile *file, size_t bytes) {
    int best = -1;
    size_t least = SIZE_MAX;
    for (int i = 0; i < file->gap_count; i++) {
        size_t size = file->gaps[i].end - file->gaps[i].first;
        if (size < bytes || size >= least) continue;
        least = size;
        best = i;
    }
    return best;
}

static bool grow(PageFile *file, size_t bytes) {
    size_t more = bytes < STEP ? STEP : bytes;
    if (more > ADDRESSES - file->size || ftruncate(file->fd, (off_t)(file->size + more)) != 0) return false;
    if (mmap(file->base + file->size, more, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_FIXED, file->fd,
             (off_t)file->size) == MAP_FAILED)
        return false;
    file->size += more;
    return add_gap(file, (Gap){file->size - more, file->size, true});
}

// ---- pieces

static size_t in_pages(size_t bytes) { return (bytes + HEAD + PAGE - 1) / PAGE * PAGE; }

static void *take_pages(PageFile *file, size_t bytes) {
    int at = find_gap(file, bytes);
    if (at < 0) {
        if (!grow(file, bytes)) return NULL;
        at = find_gap(file, bytes);
    }
    Gap *gap = &file->gaps[at];
    char *piece = file->base + gap->first;
    if (!gap->hole)
        memset(piece, 0, bytes);
    else if (posix_fallocate(file->fd, (off_t)gap->first, (off_t)bytes) != 0)
        return NULL;
    gap->first += bytes;
    if (gap->first == gap->end) remove_gap(file, at);
    file->used += bytes - HEAD;
    memcpy(piece, &bytes, sizeof bytes);
    return piece + HEAD;
}

void *page_file_take(PageFile *file, size_t bytes) {
    if (bytes > ADDRESSES) return NULL;
    pthread_mutex_lock(&file->mutex);
    void *piece = take_pages(file, in_pages(bytes));
    pthread_mutex_unlock(&file->mutex);
    return piece;
}

static size_t whole_size(const void *memory) {
    size_t bytes;
    memcpy(&bytes, (const char *)memory - HEAD, sizeof bytes);
    return bytes;
}

size_t page_file_size(const void *memory) { return whole_size(memory) - HEAD; }

void page_file_give(void *memory) {
    PageFile *file = page_file_of(memory);
    size_t bytes = whole_size(memory), first = (size_t)((char *)memory - HEAD - file->base);
    pthread_mutex_lock(&file->mutex);
    file->used -= bytes - HEAD;
    // Where there is no memory to note the gap, its pages are lost until the file goes.
    add_gap(file, (Gap){first, first + bytes, false});
    pthread_mutex_unlock(&file->mutex);
}

void page_file_drop(PageFile *file) {
    pthread_mutex_lock(&file->mutex);
    for (int i = 0; i < file->gap_count; i++) {
        Gap *gap = &file->gaps[i];
        gap->hole = gap->hole || fallocate(file->fd, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE,
                                           (off_t)gap->first, (off_t)(gap->end - gap->first)) == 0;
    }
    for (int i = file->gap_count - 2; i >= 0; i--) join_next(file, i);
    // The pages of a shared mapping stay those of the file.
    if (file->size > 0) madvise(file->base, file->size, MADV_DONTNEED);
    pthread_mutex_unlock(&file->mutex);
}

void page_file_set_asleep(PageFile *file, bool asleep) { atomic_store(&file->asleep, asleep); }
bool page_file_asleep(PageFile *file) { return atomic_load(&file->asleep); }
