// arena.c - a list of blocks, each at least twice as large as the one before up to a limit. Blocks come zeroed, large ones from the
// system, which gives them pages only where they are touched: so arrays that are hardly used take hardly any memory.
#include "engine/core/arena.h"

#include <stdint.h>
#include <stdio.h>

#include "engine/core/memory.h"

enum { ALIGNMENT = 64 };

// Under the address sanitizer, memory that was not handed out and the gap behind each piece that was are poisoned.
#ifdef __has_feature
#if __has_feature(address_sanitizer)
#define __SANITIZE_ADDRESS__ 1
#endif
#endif
#ifdef __SANITIZE_ADDRESS__
void __asan_poison_memory_region(const volatile void *from, size_t size);
void __asan_unpoison_memory_region(const volatile void *from, size_t size);
enum { GAP = ALIGNMENT };
static void forbid(const void *from, size_t size) { __asan_poison_memory_region(from, size); }
static void allow(const void *from, size_t size) { __asan_unpoison_memory_region(from, size); }
#else
enum { GAP = 0 };
static void forbid(const void *from, size_t size) { (void)from, (void)size; }
static void allow(const void *from, size_t size) { (void)from, (void)size; }
#endif

static const size_t FIRST_BLOCK = 64 * 1024;
// A block that leaves for a file (memory_use_file) is written whole, touched or not.
static const size_t LARGEST_GROWTH = 64 * 1024 * 1024, LARGEST_IN_FILE = 2 * 1024 * 1024;
// Pieces from this size on have blocks of their own.
static const size_t LARGE_PIECE = GAP > 0 ? 0 : 1024 * 1024;

struct ArenaBlock {
    ArenaBlock *next;
    void *whole;               // as it was requested
    size_t size, used, dirty;  // bytes behind this header; from `dirty` on they are zeroed
};

static const size_t HEADER = (sizeof(ArenaBlock) + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;

static ArenaBlock *new_arena_block(size_t size, bool dense) {
    size = (size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    char *whole = memory_new_zeroed(ALIGNMENT + HEADER + size);
    if (dense) memory_expect_full(whole, ALIGNMENT + HEADER + size);
    ArenaBlock *block = (ArenaBlock *)(whole + (ALIGNMENT - (uintptr_t)whole % ALIGNMENT));
    *block = (ArenaBlock){.whole = whole, .size = size};
    forbid((char *)block + HEADER, size);
    return block;
}

static size_t most_growth(void) { return memory_in_file() ? LARGEST_IN_FILE : LARGEST_GROWTH; }

static ArenaBlock *add_arena_block(Arena *arena, size_t least) {
    size_t size = arena->head ? arena->head->size * 2 : FIRST_BLOCK;
    if (size > most_growth()) size = most_growth();
    // Close to the memory limit, no block is much larger than needed.
    while (size / 2 > least && !memory_fits(size)) size /= 2;
    ArenaBlock *block = new_arena_block(size < least ? least : size, arena->dense);
    block->next = arena->head;
    return arena->head = block;
}

// A block for one large piece stands behind the first one, which goes on to be filled.
static ArenaBlock *add_own_block(Arena *arena, size_t bytes) {
    if (!arena->head) return add_arena_block(arena, bytes);
    ArenaBlock *block = new_arena_block(bytes, arena->dense);
    block->next = arena->head->next;
    return arena->head->next = block;
}

void *arena_alloc(Arena *arena, size_t count, size_t size) {
    if (size && count > (SIZE_MAX / 2 - HEADER) / size) memory_end(SIZE_MAX);
    size_t asked = count * size, bytes = (asked + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT + GAP;
    if (bytes == 0) bytes = ALIGNMENT;
    ArenaBlock *block = arena->head;
    if (!block || block->size - block->used < bytes)
        block = bytes < LARGE_PIECE ? add_arena_block(arena, bytes) : add_own_block(arena, bytes);
    char *memory = (char *)block + HEADER + block->used;
    size_t dirty = block->dirty > block->used ? block->dirty - block->used : 0;
    block->used += bytes;
    arena->used += bytes;
    if (block->dirty < block->used) block->dirty = block->used;
    if (dirty > bytes) dirty = bytes;
    allow(memory, asked);
    if (dirty > 0) memset(memory, 0, GAP > 0 && dirty > asked ? asked : dirty);
    return memory;
}

void *arena_grow(Arena *arena, void *array, int count, int *capacity, size_t size) {
    if (count < *capacity) {
        memset((char *)array + (size_t)count * size, 0, size);
        return array;
    }
    if (count > INT32_MAX / 2) memory_end((size_t)count * size);
    *capacity = *capacity < 8 ? 16 : *capacity * 2;
    void *larger = arena_alloc(arena, (size_t)*capacity, size);
    if (count) memcpy(larger, array, (size_t)count * size);
    return larger;
}

void *arena_room(Arena *arena, void *array, size_t size, int used, int needed, int *capacity) {
    if (needed <= *capacity) return array;
    int room = *capacity * 2 > needed ? *capacity * 2 : needed + 64;
    void *larger = arena_alloc(arena, (size_t)room, size);
    if (used > 0) memcpy(larger, array, (size_t)used * size);
    *capacity = room;
    return larger;
}

// Makes a block that holds nothing but this piece larger or smaller, by the system's pages where it can: so the piece is not there twice
// while it grows. Returns where the piece is then, NULL where it has no block of its own.
static void *grow_own_block(Arena *arena, const void *piece, size_t before, size_t after) {
    before = (before + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT + GAP;
    after = (after + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT + GAP;
    for (ArenaBlock **at = &arena->head; *at; at = &(*at)->next) {
        ArenaBlock *block = *at;
        if ((const char *)piece != (char *)block + HEADER) continue;
        if (block->used != before || GAP > 0) return NULL;
        size_t shift = (size_t)((char *)block - (char *)block->whole),
               held = HEADER + (before < after ? before : after);
        char *whole = memory_grow(block->whole, ALIGNMENT + HEADER + after),
             *aligned = whole + (ALIGNMENT - (uintptr_t)whole % ALIGNMENT);
        if (aligned != whole + shift) memmove(aligned, whole + shift, held);
        block = (ArenaBlock *)aligned;
        block->whole = whole;
        block->size = block->used = block->dirty = after;
        arena->used += after - before;
        *at = block;
        return aligned + HEADER;
    }
    return NULL;
}

// A piece in a block of its own, which can grow, even where another block has room for it.
static void *own_piece(Arena *arena, size_t asked) {
    size_t bytes = (asked + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT + GAP;
    ArenaBlock *block = add_own_block(arena, bytes);
    block->used = block->dirty = bytes;
    arena->used += bytes;
    allow((char *)block + HEADER, asked);
    return (char *)block + HEADER;
}

void *arena_regrow(Arena *arena, void *array, size_t size, int used, int needed, int *capacity) {
    size_t before = (size_t)*capacity * size;
    if (needed <= *capacity || !array || before < LARGE_PIECE)
        return arena_room(arena, array, size, used, needed, capacity);
    int room = before < LARGEST_GROWTH ? *capacity * 2 : *capacity + *capacity / 8;
    if (room < needed) room = needed + 64;
    void *larger = grow_own_block(arena, array, before, (size_t)room * size);
    if (!larger) {
        larger = own_piece(arena, (size_t)room * size);
        memcpy(larger, array, (size_t)used * size);
    }
    *capacity = room;
    return larger;
}

void *arena_fit(Arena *arena, void *array, size_t size, int count, int capacity) {
    if (!array || (size_t)capacity * size < LARGE_PIECE || count <= 0) return array;
    void *smaller = grow_own_block(arena, array, (size_t)capacity * size, (size_t)count * size);
    return smaller ? smaller : array;
}

void arena_release(Arena *arena, const void *piece) {
    for (ArenaBlock **at = &arena->head; *at; at = &(*at)->next) {
        ArenaBlock *block = *at;
        if ((const char *)piece != (char *)block + HEADER || block->used < LARGE_PIECE ||
            block->used != block->size)
            continue;
        arena->used -= block->used;
        *at = block->next;
        memory_free(block->whole);
        return;
    }
}

char *arena_string(Arena *arena, const char *text) {
    size_t length = strlen(text) + 1;
    return memcpy(arena_alloc(arena, length, 1), text, length);
}

char *arena_format_list(Arena *arena, const char *format, va_list args) {
    va_list again;
    va_copy(again, args);
    int length = vsnprintf(NULL, 0, format, args);
    char *text = arena_alloc(arena, (size_t)(length < 0 ? 0 : length) + 1, 1);
    if (length > 0) vsnprintf(text, (size_t)length + 1, format, again);
    va_end(again);
    return text;
}

char *arena_format(Arena *arena, const char *format, ...) {
    va_list args;
    va_start(args, format);
    char *text = arena_format_list(arena, format, args);
    va_end(args);
    return text;
}

void arena_join(Arena *to, Arena *from) {
    ArenaBlock **end = &to->head;
    while (*end) end = &(*end)->next;
    *end = from->head;
    to->used += from->used;
    *from = (Arena){.dense = from->dense};
}

void arena_free(Arena *arena) {
    while (arena->head) {
        ArenaBlock *next = arena->head->next;
        memory_free(arena->head->whole);
        arena->head = next;
    }
    arena->used = 0;
}

void arena_reset(Arena *arena) {
    ArenaBlock *largest = NULL;
    while (arena->head) {
        ArenaBlock *block = arena->head;
        arena->head = block->next;
        if (!largest || block->size > largest->size) {
            if (largest) memory_free(largest->whole);
            largest = block;
        } else {
            memory_free(block->whole);
        }
    }
    // Where several were in use, one block with room for all is next.
    size_t all = arena->used + arena->used / 4;
    if (largest && arena->used > largest->size && all <= most_growth()) {
        memory_free(largest->whole);
        largest = new_arena_block(all, arena->dense);
    }
    if (largest) {
        largest->next = NULL;
        forbid((char *)largest + HEADER, largest->used);
        largest->used = 0;
    }
    arena->head = largest;
    arena->used = 0;
}
