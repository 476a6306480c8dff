// simplify_queue.h - which corner moves next: the one that does least harm.
#ifndef RADIOSITY_SIMPLIFY_QUEUE_H
#define RADIOSITY_SIMPLIFY_QUEUE_H

#include <stdbool.h>

#include "engine/core/arena.h"

// What a corner may do: move to where `to` is.
typedef struct SimplifyMove {
    double harm;  // metres
    int from, to;
    unsigned stamp;  // of `from`, when that was so
} SimplifyMove;

// A binary heap.
typedef struct SimplifyQueue {
    SimplifyMove *moves;
    int count, capacity;
} SimplifyQueue;

// In an order without equals: results do not depend on how moves came.
static inline bool simplify_before(const SimplifyMove *a, const SimplifyMove *b) {
    if (a->harm != b->harm) return a->harm < b->harm;
    return a->from != b->from ? a->from < b->from : a->to < b->to;
}

void simplify_queue_push(SimplifyQueue *queue, Arena *arena, SimplifyMove move);
SimplifyMove simplify_queue_pop(SimplifyQueue *queue);

#endif
