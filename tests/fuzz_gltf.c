// fuzz_gltf.c - libFuzzer on the glTF reader, .gltf and .glb: whatever the bytes, it reads a building that passes the
// check, or refuses with a sentence. The folder is none, so that no file beside is opened.
#include <stdlib.h>

#include "maps/maps.h"

extern const MapsReader MAPS_READER_GLTF;
int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size);

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    Arena arena = {0};
    Building b = {0};
    Error error = {""};
    const char *fault;
    unsigned char *copy = arena_alloc(&arena, size + 1, 1);
    if (size > 0) memcpy(copy, data, size);
    Bytes content = {copy, size};
    MAPS_READER_GLTF.recognise(content);
    bool read = MAPS_READER_GLTF.read("/nowhere/fuzz.gltf", content, &arena, &b, &error);
    if (read ? building_check(&b, &arena, &fault, 1) != 0 : error.text[0] == 0) abort();
    arena_free(&arena);
    return 0;
}
