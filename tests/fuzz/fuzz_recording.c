// fuzz_recording.c - libFuzzer on the reader of recorded paths: whatever the bytes, it refuses them with a sentence or
// reads a path whose every frame could have been recorded.
#include <stdlib.h>

#include "engine/sim/recording.h"
#include "tests/fuzz/target.h"

// Adds all that was read to a new path, which refuses what recording_load must not let through.
static bool can_be_recorded(const Recording *read, const Building *building, Arena *arena) {
    Recording *again = recording_new(building, arena);
    float *doors = ARENA_ARRAY(arena, float, building->opening_count);
    for (int i = 0; i < read->frame_count; i++) {
        recording_doors(read, i, doors);
        if (!recording_add(again, &read->frames[i], doors)) return false;
    }
    return again->frame_count == read->frame_count && again->door_count == read->door_count;
}

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    // An input that does not begin as a path comes behind a good header, which is not found by chance.
    static const char HEAD[] = "enfilade path 1\nbuilding \"fuzz\" 0123456789abcdef\nticks 60\n";
    Building building = {.source = "fuzz.plan", .hash = 0x0123456789abcdefu, .opening_count = 3};
    Arena *arena = target_begin();
    Error error = {""};
    Bytes content = target_bytes(arena, size > 0 && data[0] == 'e' ? "" : HEAD, data, size);
    Recording *r = recording_read("fuzz.path", content, &building, arena, &error);
    if (r ? !can_be_recorded(r, &building, arena) : error.text[0] == 0) abort();
    if (r) target_count(TARGET_PASSED);
    return 0;
}
