// fuzz_plan.c - libFuzzer on the .plan reader.
#include "tests/fuzz/target.h"

extern const MapsReader MAPS_READER_PLAN;

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    return target_reader(&MAPS_READER_PLAN, "fuzz.plan", data, size);
}
