// fuzz_gltf.c - libFuzzer on the glTF reader, .gltf and .glb. The folder is none, so that no file beside is opened.
#include "tests/fuzz/target.h"

extern const MapsReader MAPS_READER_GLTF;

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    return target_reader(&MAPS_READER_GLTF, "/nowhere/fuzz.gltf", data, size);
}
