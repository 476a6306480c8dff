// shoot_queue.h - finds the patch with most unshot power, while the powers of many patches keep growing.
#ifndef RADIOSITY_SHOOT_QUEUE_H
#define RADIOSITY_SHOOT_QUEUE_H

#include <stdbool.h>

#include "engine/core/arena.h"

// The strongest patch of each block of patches is stored, so that raising a power costs one comparison; a binary heap would take
// several, at places far apart in memory.
typedef struct ShootQueue {
    double *power;   // [count] W
    double *most;    // [block_count] the greatest power of patches b * block .. + block - 1
    int *strongest;  // [block_count] the patch with that power, the lowest index of several
    int count, block, block_count;
} ShootQueue;

void shoot_queue_start(ShootQueue *queue, int count, Arena *arena);

// Sets the power of a patch, W; it must not be less than before.
static inline void shoot_queue_raise(ShootQueue *queue, int patch, double power) {
    int b = patch / queue->block;
    queue->power[patch] = power;
    if (power < queue->most[b] || (power == queue->most[b] && patch > queue->strongest[b])) return;
    queue->most[b] = power;
    queue->strongest[b] = patch;
}

// Sets the power of a patch to 0.
void shoot_queue_clear(ShootQueue *queue, int patch);
// The patch with most power, the lowest index of several; -1 where all powers are 0.
int shoot_queue_top(const ShootQueue *queue);
// Finds the strongest patches that have at least `least` W and are not `taken` [count]. Stores them in `patches`, in any order, and
// returns their number, at most `wanted`.
int shoot_queue_next(const ShootQueue *queue, const bool *taken, double least, int wanted, int *patches);

#endif
