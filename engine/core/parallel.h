// parallel.h - a loop over independent work on several threads.
#ifndef CORE_PARALLEL_H
#define CORE_PARALLEL_H

// Threads that waiting loops may use: the cores this process may run on.
int parallel_threads(int wanted);  // 0: all of them

// Calls body(context, index, thread) once for each index in 0 .. count - 1, on up to `threads` threads, 0 <= thread <
// threads; which thread takes which index, and when, is left to chance. Returns when all are done. A thread that waits
// sleeps: it takes nothing from other programs.
void parallel_for(int threads, int count, void (*body)(void *context, int index, int thread), void *context);

#endif
