// arena.h - memory that is freed all at once. A stage allocates its result in the caller's arena.
#ifndef CORE_ARENA_H
#define CORE_ARENA_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

// A block of an arena's memory.
typedef struct ArenaBlock ArenaBlock;

// Start with {0}, or with {.dense = true} where large amounts are written as soon as they are allocated. Only one thread at a time may
// allocate from an arena. arena_free frees everything that was allocated from it.
typedef struct Arena {
    ArenaBlock *head;
    size_t used;  // bytes handed out, for reports
    bool dense;   // its blocks are expected to be full (memory_expect_full)
} Arena;

// Returns zeroed memory, aligned to 64 bytes. Never returns NULL: lack of memory ends the program (memory.h).
void *arena_alloc(Arena *arena, size_t count, size_t size);
char *arena_string(Arena *arena, const char *text);  // a copy
// A string in the arena, as printf would print it.
char *arena_format(Arena *arena, const char *format, ...) __attribute__((format(printf, 2, 3)));
// arena_format with the arguments in a list.
char *arena_format_list(Arena *arena, const char *format, va_list args) __attribute__((format(printf, 2, 0)));
// Moves all that was allocated from `from` into `to`; `from` is then empty.
void arena_join(Arena *to, Arena *from);
void arena_free(Arena *arena);  // frees everything; the arena may be used again
// As arena_free, but keeps the largest block for the next use, or one with room for all that was in use.
void arena_reset(Arena *arena);

#define ARENA_ARRAY(arena, type, count) ((type *)arena_alloc((arena), (size_t)(count), sizeof(type)))

// Appends to a growing array: `array` (may be NULL), `count` and `capacity` are lvalues. Yields a pointer to the new, zeroed last
// element. The memory of outgrown arrays stays in the arena: at most as much again as the array itself.
#define ARENA_PUSH(arena, array, count, capacity)                                                            \
    ((array) = arena_grow((arena), (array), (count), &(capacity), sizeof *(array)), (array) + (count)++)
// Called by ARENA_PUSH: returns the array, moved if it was full, with room for one element more than `count`; the new element is
// zeroed.
void *arena_grow(Arena *arena, void *array, int count, int *capacity, size_t size);
// The array, moved if it was too small, with room for `needed` elements of `size` bytes; the first `used` are kept.
void *arena_room(Arena *arena, void *array, size_t size, int used, int needed, int *capacity);

// As arena_room, but a large array grows where it is, or its memory is moved: no pointer into it may be used any more, and new elements are
// not zeroed. For the largest arrays of a building, where the outgrown ones would be as much again.
void *arena_regrow(Arena *arena, void *array, size_t size, int used, int needed, int *capacity);

// The array, which holds `count` elements and grows no more: where it is large and grew by arena_regrow, the room for more is given back,
// and it may have moved.
void *arena_fit(Arena *arena, void *array, size_t size, int count, int capacity);

// Gives back an array that nobody reads any more, where it is large and has a block of its own; else it stays until the arena is freed.
void arena_release(Arena *arena, const void *array);

// ARENA_PUSH by arena_regrow.
#define ARENA_APPEND(arena, array, count, capacity)                                                          \
    ((array) = arena_regrow((arena), (array), sizeof *(array), (count), (count) + 1, &(capacity)),           \
     (array) + (count)++)

#endif
