// fuzz_quads.c - libFuzzer on the .quads reader.
#include "tests/fuzz/target.h"

extern const MapsReader MAPS_READER_QUADS;

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    return target_reader(&MAPS_READER_QUADS, "fuzz.quads", data, size);
}
