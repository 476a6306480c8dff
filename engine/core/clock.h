// clock.h - clocks that only go forward, for measurements. Stages and queries never read them.
#ifndef CORE_CLOCK_H
#define CORE_CLOCK_H

#include <time.h>

// Seconds since some fixed moment.
static inline double clock_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// Seconds of processor time that the calling thread has used; other programs on the machine disturb this time less.
static inline double clock_thread_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

// Seconds of processor time that all threads of the program have used.
static inline double clock_work_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

#endif
