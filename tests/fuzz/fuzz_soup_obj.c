// fuzz_soup_obj.c - libFuzzer on the reader of OBJ buildings. The folder is none, so that no file beside is opened.
#include "tests/fuzz/target.h"

extern const MapsReader MAPS_READER_OBJ;

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    return target_reader(&MAPS_READER_OBJ, "/nowhere/fuzz.obj", data, size);
}
