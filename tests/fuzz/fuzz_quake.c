// fuzz_quake.c - libFuzzer on levels of the Quake family: whatever the bytes, they are refused with a sentence, or have cells and rows, and
// take rows that are read again.
#include <stdlib.h>

#include "maps/quake/quake.h"
#include "tests/fuzz/target.h"

extern const MapsReader MAPS_READER_QUAKE;

static void write_rows(Bytes content, Arena *arena) {
    QuakeLevel level, again;
    Error error = {""};
    Bytes out;
    if (!quake_read("fuzz.bsp", content, arena, &level, &error)) abort();
    int words = (level.cluster_count + 63) / 64;
    enum { MANY = 1 << 10 };
    if (level.cluster_count > MANY) return;
    uint64_t *rows = ARENA_ARRAY(arena, uint64_t, level.cluster_count * words);
    if (!quake_rows(&level, words, rows, &error) && error.text[0] == 0) abort();
    if (!quake_with_rows(&level, rows, words, arena, &out, &error)) {
        if (error.text[0] == 0) abort();
        return;
    }
    uint64_t *found = ARENA_ARRAY(arena, uint64_t, level.cluster_count * words);
    if (!quake_read("fuzz.bsp", out, arena, &again, &error) || !quake_rows(&again, words, found, &error) ||
        memcmp(rows, found, (size_t)(level.cluster_count * words) * sizeof *rows) != 0)
        abort();
}

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    Arena *arena = target_begin();
    Building b = {0};
    Bytes content = target_bytes(arena, "", data, size);
    if (target_read(&MAPS_READER_QUAKE, "fuzz.bsp", content, arena, &b)) write_rows(content, arena);
    return 0;
}
