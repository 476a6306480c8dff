// parallel.h - a loop over independent work on several threads.
#ifndef CORE_PARALLEL_H
#define CORE_PARALLEL_H

// The number of threads for a loop: `wanted`, or for 0 the number of cores on which this process may run; at most 256.
int parallel_threads(int wanted);

// Calls body(context, index, thread) once for each index in 0 .. count - 1, on up to `threads` threads, 0 <= thread < threads;
// which thread takes which index, and when, is not determined. Returns when all calls are done. Waiting threads sleep, so they take
// no time from other programs.
void parallel_for(int threads, int count, void (*body)(void *context, int index, int thread), void *context);

#endif
