// fuzz_prt.c - libFuzzer on the reader of portal files.
#include "tests/fuzz/target.h"

extern const MapsReader MAPS_READER_PRT;

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    return target_reader(&MAPS_READER_PRT, "fuzz.prt", data, size);
}
