// shoot_queue.h - which patch has most unshot power, of many whose powers grow all the time.
#ifndef RADIOSITY_SHOOT_QUEUE_H
#define RADIOSITY_SHOOT_QUEUE_H

#include <stdbool.h>

#include "engine/core/arena.h"

// The strongest of each block of patches is known, so that a power that grows costs one comparison; a binary heap takes
// several, at places far apart.
typedef struct ShootQueue {
    double *power;   // [count] W
    double *most;    // [block_count] the greatest power of patches b * block .. + block - 1
    int *strongest;  // [block_count] which has it, the lowest of several
    int count, block, block_count;
} ShootQueue;

void shoot_queue_start(ShootQueue *queue, int count, Arena *arena);

// `power` is at least what it was.
static inline void shoot_queue_raise(ShootQueue *queue, int patch, double power) {
    int b = patch / queue->block;
    queue->power[patch] = power;
    if (power < queue->most[b] || (power == queue->most[b] && patch > queue->strongest[b])) return;
    queue->most[b] = power;
    queue->strongest[b] = patch;
}

void shoot_queue_clear(ShootQueue *queue, int patch);
// The patch with most power, the lowest of several; -1 where all have none.
int shoot_queue_top(const ShootQueue *queue);
// The strongest of those not `taken` [count] that have at least `least` W, in any order; returns how many, at most `wanted`.
int shoot_queue_next(const ShootQueue *queue, const bool *taken, double least, int wanted, int *patches);

#endif
