// parallel.c - a loop on several threads, which are started for each loop and take indices from a common counter. OpenMP does the
// same with less code, but its threads spin while they wait: on a busy machine short loops then take a hundred times as long.
#include "engine/core/parallel.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <string.h>

#include "engine/core/memory.h"

enum { MOST_THREADS = 256 };

typedef struct Loop {
    void (*body)(void *context, int index, int thread);
    void *context;
    int count;
    atomic_int next;
    PageFile *file;  // of the thread that waits for the loop
} Loop;

typedef struct Worker {
    Loop *loop;
    int thread;
} Worker;

int parallel_threads(int wanted) {
    cpu_set_t cores;
    if (wanted <= 0) wanted = sched_getaffinity(0, sizeof cores, &cores) == 0 ? CPU_COUNT(&cores) : 1;
    return wanted < 1 ? 1 : wanted > MOST_THREADS ? MOST_THREADS : wanted;
}

static void *work(void *argument) {
    const Worker *worker = argument;
    Loop *loop = worker->loop;
    memory_use_file(loop->file);
    for (int i; (i = atomic_fetch_add(&loop->next, 1)) < loop->count;)
        loop->body(loop->context, i, worker->thread);
    return 0;
}

void parallel_for(int threads, int count, void (*body)(void *context, int index, int thread), void *context) {
    Loop loop = {.body = body, .context = context, .count = count};
    Worker workers[MOST_THREADS];
    pthread_t handles[MOST_THREADS];
    int started = 1;
    loop.file = memory_use_file(NULL);
    if (threads > count) threads = count;
    // If a thread cannot be started, the loop runs on the threads that were started before.
    for (; started < threads && started < MOST_THREADS; started++) {
        workers[started] = (Worker){&loop, started};
        if (pthread_create(&handles[started], 0, work, &workers[started]) != 0) break;
    }
    workers[0] = (Worker){&loop, 0};
    work(&workers[0]);
    for (int i = 1; i < started; i++) pthread_join(handles[i], 0);
}

// ---- processes

static const ParallelRanks *all_ranks;
static bool inside;  // a loop that processes share

void parallel_set_ranks(const ParallelRanks *ranks) { all_ranks = ranks; }

// Indices of a shared loop that this process took at a time.
typedef struct Stretch {
    const SharedLoop *loop;
    int first, count;
} Stretch;

static void work_at(void *context, int index, int thread) {
    const Stretch *s = context;
    s->loop->body(s->loop->context, s->first + index, thread);
}

// Stretches become short enough that processes end at about the same time.
static int stretch_length(int threads, int count) {
    enum { STRETCHES = 16 };
    int length = count / (STRETCHES * all_ranks->count);
    return length < threads ? threads : length;
}

// A result is its index, its size and its bytes.
typedef struct ResultHead {
    size_t size;
    long long index;
} ResultHead;

static void put_result(const SharedLoop *loop, int index, Bytes *all, size_t *room, Arena *arena) {
    Arena scratch = {0};
    Bytes bytes = loop->pack(loop->context, index, &scratch);
    ResultHead head = {bytes.size, index};
    size_t size = all->size + sizeof head + bytes.size;
    if (size > *room) {
        unsigned char *old = all->data;
        *room = 2 * size;
        all->data = arena_alloc(arena, *room, 1);
        if (all->size > 0) memcpy(all->data, old, all->size);
    }
    memcpy(all->data + all->size, &head, sizeof head);
    if (bytes.size > 0) memcpy(all->data + all->size + sizeof head, bytes.data, bytes.size);
    all->size = size;
    arena_free(&scratch);
}

static void take_results(const SharedLoop *loop, Bytes from) {
    for (size_t at = 0; at < from.size;) {
        ResultHead head;
        memcpy(&head, from.data + at, sizeof head);
        at += sizeof head;
        loop->unpack(loop->context, (int)head.index, (Bytes){from.data + at, head.size});
        at += head.size;
    }
}

void parallel_share(int threads, const SharedLoop *loop) {
    if (!all_ranks || inside) {
        parallel_for(threads, loop->count, loop->body, loop->context);
        return;
    }
    Arena arena = {0};
    Bytes own = {0};
    size_t room = 0;
    int length = stretch_length(threads, loop->count);
    inside = true;
    for (int first; (first = all_ranks->take(length)) < loop->count;) {
        int left = loop->count - first;
        Stretch stretch = {loop, first, left < length ? left : length};
        parallel_for(threads, stretch.count, work_at, &stretch);
        for (int i = 0; i < stretch.count; i++) put_result(loop, first + i, &own, &room, &arena);
    }
    inside = false;
    const Bytes *all = all_ranks->collect(own, &arena);
    for (int r = 0; r < all_ranks->count; r++)
        if (r != all_ranks->own) take_results(loop, all[r]);
    arena_free(&arena);
}

bool parallel_agree(bool value) {
    if (!all_ranks || inside) return value;
    Arena arena = {0};
    unsigned char own = value;
    const Bytes *all = all_ranks->collect((Bytes){&own, 1}, &arena);
    for (int r = 0; r < all_ranks->count; r++) value = value && *all[r].data;
    arena_free(&arena);
    return value;
}

bool parallel_is_first(void) { return !all_ranks || all_ranks->own == 0; }
