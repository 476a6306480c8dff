// fuzz_sh3d.c - any bytes as a Home.xml (first byte 0), a ZIP (1), an OBJ model (2), an SVG path (3) or an image
// (4): never a crash, a hang or a leak.
#include <stdint.h>
#include <string.h>

#include "maps/sh3d.h"
#include "maps/texture.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void read_home(Bytes content, bool zip, Arena *arena) {
    Building b = {0};
    Sketch sketch = {0};
    Error error;
    Archive *archive = NULL;
    Bytes xml = content;
    bool good = true;
    if (zip)
        good = archive_open(content, "fuzz.sh3d", arena, &archive, &error) &&
               archive_read(archive, "Home.xml", SH3D_MAX_XML, arena, &xml, &error);
    if (good) sh3d_sketch(xml, archive, "Home.xml", arena, &b, &sketch, &error);
    archive_close(archive);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    if (size == 0) return 0;
    Arena arena = {0};
    Bytes content = {arena_alloc(&arena, size, 1), size - 1};
    memcpy(content.data, data + 1, size - 1);
    ObjModel model;
    Error error;
    Vec2 shape[SH3D_MAX_SHAPE];
    Rgb mean;
    switch (data[0] % 5) {
    case 0:
        read_home(content, false, &arena);
        break;
    case 1:
        read_home(content, true, &arena);
        break;
    case 2:
        obj_read(content, "fuzz.obj", NULL, &arena, &model, &error);
        break;
    case 3:
        sh3d_shape((const char *)content.data, shape, SH3D_MAX_SHAPE);
        break;
    default:
        texture_mean(content, &mean);
        break;
    }
    arena_free(&arena);
    return 0;
}
