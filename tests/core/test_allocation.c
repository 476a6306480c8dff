// test_allocation.c - the query allocates nothing once it is warm: every allocating function of the C library is
// interposed and counted.
#include <criterion/criterion.h>
#include <errno.h>
#include <stdlib.h>

#include "tests/support/fixture.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define INTERPOSED 0  // the sanitizer has its own allocator in this place
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define INTERPOSED 0
#endif
#endif
#ifndef INTERPOSED
#define INTERPOSED 1
#endif

// volatile: the compiler knows malloc and would move the switch past it.
static _Thread_local volatile bool counting;
static _Thread_local volatile int allocations;

#if INTERPOSED
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *memory, size_t size);
void *__libc_memalign(size_t alignment, size_t size);

void *malloc(size_t size) {
    allocations = allocations + counting;
    return __libc_malloc(size);
}
void *calloc(size_t count, size_t size) {
    allocations = allocations + counting;
    return __libc_calloc(count, size);
}
void *realloc(void *memory, size_t size) {
    allocations = allocations + counting;
    return __libc_realloc(memory, size);
}
void *aligned_alloc(size_t alignment, size_t size) {
    allocations = allocations + counting;
    return __libc_memalign(alignment, size);
}
int posix_memalign(void **out, size_t alignment, size_t size) {
    allocations = allocations + counting;
    *out = __libc_memalign(alignment, size);
    return *out ? 0 : ENOMEM;
}
#endif

// Proves that vis_query and vis_locate allocate nothing, from the first query on, by any method; and, with one call
// that does allocate, that the count would show it.
Test(query, allocates_nothing) {
    if (!INTERPOSED) cr_skip_test("the sanitizer's allocator stands in the way");
    Arena arena = {0};
    Random random = {21};
    Building *b = fixture_rooms(&arena, &random, 6, 6, 2);
    VisOptions options = vis_default_options();
    CellGraph graph;
    StabForest forest;
    Error error;
    cr_assert(vis_build_cells(b, &options, &arena, &graph, &error), "%s", error.text);
    cr_assert(vis_build_forest(&graph, &options, NULL, &arena, &forest));
    VisQuery *query = vis_query_new(&graph, &forest, &arena);
    float *doors = ARENA_ARRAY(&arena, float, b->opening_count + 1);
    int objects = 0;
    for (int i = 0; i < 2000; i++) {
        Eye eye = {.position = fixture_point(&graph, &random, random_index(&random, graph.cell_count))};
        for (int d = 0; d < b->opening_count; d++) doors[d] = random_unit(&random) < 0.5;
        counting = true;
        int cell = vis_locate(&graph, eye.position, -1);
        objects += vis_query(query, &eye, cell, doors, (Culling)(i % QUERY_CULLINGS)).object_count;
        counting = false;
    }
    cr_assert_gt(objects, 0);
    cr_assert_eq(allocations, 0, "%d allocations in 2000 queries", allocations);
    counting = true;
    void *volatile memory = malloc(1);
    counting = false;
    free(memory);
    cr_assert_eq(allocations, 1, "the interposed malloc does not count");
    arena_free(&arena);
}
