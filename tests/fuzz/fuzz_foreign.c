// fuzz_foreign.c - libFuzzer on the reader of COLLADA and 3DS. assimp runs in a process of its own, so that its crashes are no crashes
// here: what is tried is that each costs a sentence, and what becomes of its text.
#include "tests/fuzz/target.h"

extern const MapsReader MAPS_READER_FOREIGN;

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    return target_reader(&MAPS_READER_FOREIGN, "/nowhere/fuzz.dae", data, size);
}
