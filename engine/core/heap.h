// heap.h - a binary heap (J. W. J. Williams 1964) in an array of the caller's: the item that comes before all others is first.
#ifndef CORE_HEAP_H
#define CORE_HEAP_H

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

// All functions are inlined into their callers, where the compiler knows the size of an item and their order.
#define HEAP_INLINE static inline __attribute__((always_inline))

typedef struct Heap {
    void *items;  // [count] the caller counts them
    size_t size;  // of an item, bytes
    // Does item a leave before item b? No two items are alike, so that the order in which they came does not matter.
    bool (*before)(const void *context, const void *a, const void *b);
    const void *context;
    int *
        slot;  // [numbers] of items that are numbers (int): the place of each in `items`; NULL: nobody asks for it
} Heap;

HEAP_INLINE void *heap_at(const Heap *heap, int at) { return (char *)heap->items + (size_t)at * heap->size; }

HEAP_INLINE void heap_put(const Heap *heap, int at, const void *item) {
    if (heap->slot) heap->slot[*(const int *)item] = at;
    memcpy(heap_at(heap, at), item, heap->size);
}

// The item comes in at a place that is free, the end or its own, and rises as far as it has to.
HEAP_INLINE void heap_rise(const Heap *heap, int at, const void *item) {
    for (; at > 0 && heap->before(heap->context, item, heap_at(heap, (at - 1) / 2)); at = (at - 1) / 2)
        heap_put(heap, at, heap_at(heap, (at - 1) / 2));
    heap_put(heap, at, item);
}

// The item takes the place of the first of `count` items, and sinks. The hole sinks to the end, and the item rises from there: most
// often the item is the last one of the heap, which seldom rises far.
HEAP_INLINE void heap_replace_first(const Heap *heap, int count, const void *item) {
    int at = 0, child = 1;
    for (; child + 1 < count; child = 2 * at + 1) {
        child += heap->before(heap->context, heap_at(heap, child + 1), heap_at(heap, child));
        heap_put(heap, at, heap_at(heap, child));
        at = child;
    }
    if (child < count) {
        heap_put(heap, at, heap_at(heap, child));
        at = child;
    }
    heap_rise(heap, at, item);
}

// Takes the first of `count` items out: one fewer are left.
HEAP_INLINE void heap_drop_first(const Heap *heap, int count) {
    if (count > 1) heap_replace_first(heap, count - 1, heap_at(heap, count - 1));
}

#endif
