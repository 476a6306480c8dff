// fuzz_plan.c - libFuzzer on the .plan reader, beside which one picture lies, `oak.png`.
#include "tests/fuzz/target.h"

extern const MapsReader MAPS_READER_PLAN;

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    static unsigned char picture[] = {
        137, 80,  78, 71,  13,  10,  26,  10, 0,   0,   0,   13,  73,  72, 68, 82,  0,   0,  0,  2,   0,
        0,   0,   2,  8,   6,   0,   0,   0,  114, 182, 13,  36,  0,   0,  0,  26,  73,  68, 65, 84,  120,
        218, 99,  56, 97,  35,  242, 95,  35, 234, 196, 127, 134, 168, 19, 26, 255, 57,  57, 57, 25,  0,
        71,  138, 6,  197, 201, 190, 252, 18, 0,   0,   0,   0,   73,  69, 78, 68,  174, 66, 96, 130, 0};
    static const TargetFile FILES[] = {{"oak.png", {picture, sizeof picture - 1}}};
    target_serve(FILES, 1);
    return target_reader(&MAPS_READER_PLAN, "fuzz.plan", data, size);
}
