// fuzz_sh3d.c - libFuzzer on homes of Sweet Home 3D: a Home.xml, a stream of Java objects or a ZIP becomes a building that passes the
// check, or is refused with a sentence. Behind a first byte that begins none of these stand what ZIPs hold, where checksums keep the
// fuzzer from it: an OBJ model, an SVG path or an image.
#include <stdlib.h>

#include "maps/building/texture.h"
#include "maps/sweethome/sh3d.h"
#include "tests/fuzz/target.h"

extern const MapsReader MAPS_READER_SH3D;

static void read_part(unsigned char kind, Bytes content, Arena *arena) {
    enum { MODEL, SHAPE, IMAGE, KINDS };
    ObjModel model;
    Error error = {""};
    Vec2 shape[SH3D_MAX_SHAPE];
    Rgb mean;
    switch (kind % KINDS) {
    case MODEL:
        if (!obj_read(content, "fuzz.obj", NULL, arena, &model, &error) && error.text[0] == 0) abort();
        break;
    case SHAPE:
        sh3d_shape((const char *)content.data, shape, SH3D_MAX_SHAPE);
        break;
    default:
        texture_mean(content, NULL, &mean);
        break;
    }
}

int LLVMFuzzerTestOneInput(const unsigned char *data, size_t size) {
    if (size == 0) return 0;
    if (data[0] == '<' || data[0] == 'P' || data[0] == 0xAC)
        return target_reader(&MAPS_READER_SH3D, "fuzz.sh3d", data, size);
    Arena *arena = target_begin();
    read_part(data[0], target_bytes(arena, "", data + 1, size - 1), arena);
    return 0;
}
