// fuzz_seen.c - libFuzzer on the .seen reader: whatever the bytes, it reads rows in which every cell sees itself, or
// refuses with a sentence.
#include <stdlib.h>

#include "tests/fuzz/target.h"
#include "visibility/pairs/seen_file.h"

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    Arena *arena = target_begin();
    Error error = {""};
    uint64_t *rows = NULL;
    Bytes content = target_bytes(arena, "", data, size);
    int cells = size > 0 && data[0] > 0 ? data[0] : 1;  // as the file tells, so that its rows are looked at
    bool read = seen_parse("fuzz.seen", content, cells, arena, &rows, &error);
    size_t words = ((size_t)cells + 63) / 64;
    for (int i = 0; read && i < cells; i++) {
        if (!(rows[(size_t)i * words + (size_t)i / 64] >> (i % 64) & 1)) abort();
    }
    if (!read && error.text[0] == 0) abort();
    if (read) target_count(TARGET_PASSED);
    return 0;
}
