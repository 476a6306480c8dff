// try_fuzz.c - a short run of a fuzz target without libFuzzer: every seed file as it is, then with random damage, for
// some seconds. `try_fuzz_NAME SECONDS SEED FILE...`; a crash names the file and the number of the damage.
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "engine/core/clock.h"
#include "engine/core/random.h"
#include "tests/fuzz/target.h"

size_t LLVMFuzzerMutate(unsigned char *data, size_t size, size_t room);
size_t LLVMFuzzerCustomMutator(unsigned char *data, size_t size, size_t room, unsigned seed);

static const size_t LARGEST =
    64 * 1024;            // larger seeds are cut: many small tries find more than few large ones
static char trying[512];  // for the signal handler

static void died(int signal) {
    ssize_t written = write(STDERR_FILENO, trying, strlen(trying));
    (void)written;
    _exit(128 + signal);
}

static unsigned below(Random *random, size_t count) { return (unsigned)(random_next(random) % count); }

static Random random_bytes;

// Changes, repeats, drops or swaps some bytes; returns the new size, at most `room`.
size_t LLVMFuzzerMutate(unsigned char *data, size_t size, size_t room) {
    Random *random = &random_bytes;
    static const unsigned char TELLING[] = {0, 1, 0x7f, 0x80, 0xff, '-', '9', '.', ' ', '\n', '"', '{', '<'};
    for (unsigned n = 1 + below(random, 8); n > 0 && size > 0; n--) {
        size_t at = below(random, size), length = 1 + below(random, 16);
        if (length > size - at) length = size - at;
        switch (below(random, 5)) {
        case 0:
            data[at] = (unsigned char)random_next(random);
            break;
        case 1:
            memset(data + at, TELLING[below(random, sizeof TELLING)], length);
            break;
        case 2:  // dropped
            memmove(data + at, data + at + length, size - at - length);
            size -= length;
            break;
        case 3:  // twice
            if (size + length > room) break;
            memmove(data + at + length, data + at, size - at);
            size += length;
            break;
        default:  // cut short
            if (below(random, 8) == 0) size = at;
            break;
        }
    }
    return size;
}

int main(int argc, char **argv) {
    if (argc < 4) return 2;
    double end = clock_seconds() + atof(argv[1]);
    random_bytes.state = (uint64_t)atoll(argv[2]);
    Arena arena = {0};
    unsigned char *data = arena_alloc(&arena, 2 * LARGEST, 1);
    signal(SIGABRT, died);
    signal(SIGSEGV, died);
    signal(SIGFPE, died);
    long tries = 0;
    for (bool first = true; first || clock_seconds() < end; first = false) {
        for (int i = 3; i < argc && (first || clock_seconds() < end); i++) {
            Arena scratch = {0};
            Bytes seed;
            target_serve(NULL, 0);
            if (!file_read(argv[i], (size_t)1 << 30, &scratch, &seed, NULL)) return 2;
            size_t size = seed.size < LARGEST ? seed.size : LARGEST;
            if (size > 0) memcpy(data, seed.data, size);
            if (!first)
                size = LLVMFuzzerCustomMutator(data, size, 2 * LARGEST, (unsigned)random_next(&random_bytes));
            snprintf(trying, sizeof trying, "try %ld, seed %s, of %s\n", tries++, argv[2], argv[i]);
            LLVMFuzzerTestOneInput(data, size);
            arena_free(&scratch);
        }
    }
    printf("%ld tries\n", tries);
    arena_free(&arena);
    return 0;
}
