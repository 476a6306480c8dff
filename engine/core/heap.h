// heap.h - a binary heap (J. W. J. Williams 1964) in an array of the caller: the first item comes before all others.
#ifndef CORE_HEAP_H
#define CORE_HEAP_H

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

// All functions are inlined into their callers, where the compiler knows the size and the order of the items.
#define HEAP_INLINE static inline __attribute__((always_inline))

typedef struct Heap {
    void *items;  // [count] the caller counts them
    size_t size;  // of an item, bytes
    // Does item a leave the heap before item b? No two items may be equal, so that the order in which they were added does not
    // matter.
    bool (*before)(const void *context, const void *a, const void *b);
    const void *context;
    // [numbers] where the items are numbers (int): the place of each number in `items`; NULL: places are not recorded.
    int *slot;
} Heap;

HEAP_INLINE void *heap_at(const Heap *heap, int at) { return (char *)heap->items + (size_t)at * heap->size; }

HEAP_INLINE void heap_put(const Heap *heap, int at, const void *item) {
    if (heap->slot) heap->slot[*(const int *)item] = at;
    memcpy(heap_at(heap, at), item, heap->size);
}

// Puts the item at a free place, the end of the heap or its own earlier place, and lets it rise as far as it has to.
HEAP_INLINE void heap_rise(const Heap *heap, int at, const void *item) {
    for (; at > 0 && heap->before(heap->context, item, heap_at(heap, (at - 1) / 2)); at = (at - 1) / 2)
        heap_put(heap, at, heap_at(heap, (at - 1) / 2));
    heap_put(heap, at, item);
}

// Replaces the first of `count` items by `item`. The hole sinks to the end of the heap and the item rises from there: most often
// the item was the last one of the heap, which seldom rises far.
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

// Removes the first of `count` items; the caller lowers its count by one.
HEAP_INLINE void heap_drop_first(const Heap *heap, int count) {
    if (count > 1) heap_replace_first(heap, count - 1, heap_at(heap, count - 1));
}

#endif
