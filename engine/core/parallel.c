// parallel.c - a loop on several threads, which are started for each loop and take indices from a common counter. OpenMP does the
// same with less code, but its threads spin while they wait: on a busy machine short loops then take a hundred times as long.
#include "engine/core/parallel.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdbool.h>

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
