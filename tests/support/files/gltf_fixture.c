// gltf_fixture.c - glTF documents of one room.
#include "tests/support/files/gltf_fixture.h"

extern const MapsReader MAPS_READER_GLTF;

void gltf_room_bytes(unsigned char out[GLTF_BYTES]) {
    float position[24];
    uint16_t index[36];
    for (int i = 0; i < 8; i++) {
        position[3 * i] = (float)SOUPS_ROOM[i][0];
        position[3 * i + 1] = (float)SOUPS_ROOM[i][2];
        position[3 * i + 2] = (float)-SOUPS_ROOM[i][1];
    }
    for (int i = 0; i < 36; i++) {
        static const int CORNER[6] = {0, 1, 2, 0, 2, 3};
        index[i] = (uint16_t)SOUPS_WALL[i / 6][CORNER[i % 6]];
    }
    memcpy(out, position, GLTF_POSITIONS);
    memcpy(out + GLTF_POSITIONS, index, GLTF_INDICES);
}

char *gltf_base64(Arena *arena, const unsigned char *data, size_t size) {
    static const char DIGIT[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char *out = arena_alloc(arena, size / 3 * 4 + 5, 1), *to = out;
    for (size_t i = 0; i < size; i += 3) {
        unsigned three = (unsigned)data[i] << 16;
        if (i + 1 < size) three |= (unsigned)data[i + 1] << 8;
        if (i + 2 < size) three |= data[i + 2];
        for (int k = 0; k < 4; k++) *to++ = i + (size_t)k > size ? '=' : DIGIT[three >> (18 - 6 * k) & 63];
    }
    return out;
}

GltfDocument gltf_usual(void) {
    return (GltfDocument){
        .asset = "{\"version\":\"2.0\"}",
        .head = "",
        .scene = "\"scene\":0,\"scenes\":[{\"nodes\":[0]}]",
        .nodes = "[{\"mesh\":0,\"name\":\"room\"}]",
        .mesh = "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}",
        .accessors = "[{\"bufferView\":0,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\"},"
                     "{\"bufferView\":1,\"componentType\":5123,\"count\":36,\"type\":\"SCALAR\"}]",
        .views = "[{\"buffer\":0,\"byteLength\":96},{\"buffer\":0,\"byteOffset\":96,\"byteLength\":72}]",
        .buffer = NULL,
    };
}

char *gltf_document(Arena *arena, const GltfDocument *d) {
    unsigned char bytes[GLTF_BYTES];
    gltf_room_bytes(bytes);
    const char *buffer = d->buffer ? d->buffer
                                   : arena_format(arena, "{\"byteLength\":168,\"uri\":\"data:;base64,%s\"}",
                                                  gltf_base64(arena, bytes, GLTF_BYTES));
    return arena_format(arena,
                        "{\"asset\":%s,%s%s,\"nodes\":%s,\"meshes\":[%s],\"accessors\":%s,\"bufferViews\":%s,"
                        "\"buffers\":[%s]}",
                        d->asset, d->head, d->scene, d->nodes, d->mesh, d->accessors, d->views, buffer);
}

void gltf_accept(Arena *arena, const GltfDocument *d, Building *b) {
    soups_accept(&MAPS_READER_GLTF, "t.gltf", gltf_document(arena, d), arena, b);
}

void gltf_refuse(const GltfDocument *d, const char *expected) {
    Arena arena = {0};
    soups_refuse(&MAPS_READER_GLTF, "t.gltf", gltf_document(&arena, d), expected);
    arena_free(&arena);
}

void gltf_put_word(unsigned char *at, size_t value) {
    uint32_t word = (uint32_t)value;
    memcpy(at, &word, sizeof word);
}

Bytes gltf_binary(Arena *arena, const char *json) {
    size_t text = (strlen(json) + 3) / 4 * 4, size = 12 + 8 + text + 8 + GLTF_BYTES;
    unsigned char *out = arena_alloc(arena, size, 1);
    gltf_put_word(out, 0x46546C67), gltf_put_word(out + 4, 2), gltf_put_word(out + 8, size);
    gltf_put_word(out + 12, text), gltf_put_word(out + 16, 0x4E4F534A);
    memset(out + 20, ' ', text);
    memcpy(out + 20, json, strlen(json));
    gltf_put_word(out + 20 + text, GLTF_BYTES), gltf_put_word(out + 24 + text, 0x004E4942);
    gltf_room_bytes(out + 28 + text);
    return (Bytes){out, size};
}
