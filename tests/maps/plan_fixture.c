// plan_fixture.c - see the header.
#include "tests/maps/plan_fixture.h"

#include <criterion/criterion.h>

#include "engine/core/random.h"
#include "tests/support/support.h"

bool plan_read_bytes(Arena *arena, const void *data, size_t size, Building *b, Error *error) {
    unsigned char *copy = arena_alloc(arena, size + 1, 1);
    memcpy(copy, data, size);
    memset(b, 0, sizeof *b);
    return MAPS_READER_PLAN.read("t.plan", (Bytes){copy, size}, arena, b, error);
}

bool plan_read_text(Arena *arena, const char *text, Building *b, Error *error) {
    return plan_read_bytes(arena, text, strlen(text), b, error);
}

void plan_read_more(Arena *arena, const char *more, Building *b) {
    Error error = {""};
    cr_assert(plan_read_text(arena, arena_format(arena, "%s%s", HEAD, more), b, &error), "%s: %s", more,
              error.text);
}
