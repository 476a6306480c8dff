// test_gltf.c - the glTF reader: containers, accessors, the node forest, looks, lights and cameras.
#include <criterion/criterion.h>
#include <stdio.h>

#include "engine/core/text.h"
#include "tests/support/files/gltf_fixture.h"
#include "tests/support/support.h"

extern const MapsReader MAPS_READER_GLTF, MAPS_READER_QUADS;

static void quads_room(Arena *arena, Building *out) {
    Text text = {.arena = arena};
    for (int i = 0; i < 6; i++) {
        text_append(&text, "quad q%d 0.5 0", i);
        for (int k = 0; k < 12; k++) text_append(&text, " %g", SOUPS_ROOM[SOUPS_WALL[i][k / 3]][k % 3]);
        text_append(&text, "\n");
    }
    soups_accept(&MAPS_READER_QUADS, "t.quads", text.data, arena, out);
}

// ---- containers

// One room as .gltf with its bytes inside, as .gltf beside a file, and as .glb gives the polygons of the .quads room.
Test(gltf, same_room) {
    Arena arena = {0};
    Building quads, inside, beside, again, glb;
    Error error = {""};
    quads_room(&arena, &quads);
    GltfDocument d = gltf_usual();
    gltf_accept(&arena, &d, &inside);
    soups_expect_same(&quads, &inside);
    cr_assert_eq(inside.object_count, 1);
    cr_expect_str_eq(inside.objects[0].name, "room");
    cr_expect_eq(soups_notes(&inside, "reflect more than 0.85"), 1, "the default material is white");

    const char *folder = support_folder(&arena), *path = arena_format(&arena, "%s/r.gltf", folder);
    unsigned char bytes[GLTF_BYTES];
    gltf_room_bytes(bytes);
    cr_assert(file_write(arena_format(&arena, "%s/a b.bin", folder), bytes, GLTF_BYTES, &error), "%s",
              error.text);
    d.buffer = "{\"byteLength\":168,\"uri\":\"a%20b.bin\"}";
    const char *text = gltf_document(&arena, &d);
    cr_assert(file_write(path, text, strlen(text), &error), "%s", error.text);
    cr_assert(maps_read(path, &arena, &beside, &error), "%s", error.text);
    soups_expect_same(&quads, &beside);
    float wider = 0.5f;
    memcpy(bytes, &wider, sizeof wider);
    cr_assert(file_write(arena_format(&arena, "%s/a b.bin", folder), bytes, GLTF_BYTES, &error), "%s",
              error.text);
    cr_assert(maps_read(path, &arena, &again, &error), "%s", error.text);
    cr_expect_neq(beside.hash, again.hash, "other bytes beside make another building");

    d.buffer = "{\"byteLength\":168}";
    Bytes file = gltf_binary(&arena, gltf_document(&arena, &d));
    cr_assert(soups_read(&MAPS_READER_GLTF, "t.glb", file.data, file.size, &arena, &glb, &error), "%s",
              error.text);
    soups_expect_same(&quads, &glb);
    arena_free(&arena);
}

// Chunks that lie about their length or kind are refused with their byte.
Test(gltf, broken_containers) {
    Arena arena = {0};
    GltfDocument d = gltf_usual();
    d.buffer = "{\"byteLength\":168}";
    Bytes file = gltf_binary(&arena, gltf_document(&arena, &d));
    size_t text;
    uint32_t word;
    memcpy(&word, file.data + 12, sizeof word);
    text = word;
    static const struct {
        int at;
        uint32_t value;
        const char *expected;
    } CASES[] = {{4, 1, "byte 4: version 1 (allowed: 2)"},
                 {8, 100, "byte 8: the length is given as 100"},
                 {8, 0xFFFFFFFF, "byte 8: the length is given as 4294967295"},
                 {12, 0xFFFFFFFF, "byte 12: chunk 0 is cut short"},
                 {12, 0, "byte 20: chunk 1 is cut short"},
                 {16, 7, "byte 16: the first chunk has type 00000007"},
                 {20, 0x20202020, "line 1 of the JSON"}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        unsigned char *copy = arena_alloc(&arena, file.size, 1);
        memcpy(copy, file.data, file.size);
        gltf_put_word(copy + CASES[i].at, CASES[i].value);
        Building b;
        Error error = {""};
        cr_expect(!soups_read(&MAPS_READER_GLTF, "t.glb", copy, file.size, &arena, &b, &error));
        cr_expect(strstr(error.text, CASES[i].expected), "%s\n%s", error.text, CASES[i].expected);
    }
    // Another kind of second chunk is no GLTF_BYTES chunk; so the first buffer has no bytes.
    gltf_put_word(file.data + 24 + text, 7);
    Building b;
    Error error = {""};
    cr_expect(!soups_read(&MAPS_READER_GLTF, "t.glb", file.data, file.size, &arena, &b, &error));
    cr_expect(strstr(error.text, "buffers[0].uri: is missing"), "%s", error.text);
    for (size_t size = 0; size < file.size; size++)
        cr_expect(!soups_read(&MAPS_READER_GLTF, "t.glb", file.data, size, &arena, &b, &error), "cut at %zu",
                  size);
    soups_refuse(&MAPS_READER_GLTF, "t.gltf", "", "t.gltf: byte 0");
    soups_refuse(&MAPS_READER_GLTF, "t.gltf", "[]", "is no object");
    soups_refuse(&MAPS_READER_GLTF, "t.gltf", "{}", "asset.version: is missing");
    char *deep = arena_alloc(&arena, 5000, 1);
    memset(deep, '[', 4999);
    soups_refuse(&MAPS_READER_GLTF, "t.gltf", deep, "maximum parsing depth");
    arena_free(&arena);
}

// ---- numbers

// A floor of 4 x 2 m, its numbers in the hexadecimal bytes `hex`.
typedef struct Floor {
    const char *what, *accessors, *views, *hex, *nodes;
    int mode;
    bool indexed;
} Floor;

static void accept_floor(Arena *arena, const Floor *f, Building *b) {
    unsigned char bytes[256];
    int size = 0, used;
    unsigned byte;
    for (const char *at = f->hex; sscanf(at, " %2x%n", &byte, &used) == 1; at += used)
        bytes[size++] = (unsigned char)byte;
    GltfDocument d = gltf_usual();
    d.accessors = f->accessors, d.views = f->views, d.nodes = f->nodes;
    d.mesh = arena_format(arena, "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"mode\":%d%s}]}",
                          f->mode, f->indexed ? ",\"indices\":1" : "");
    d.buffer = arena_format(arena, "{\"byteLength\":%d,\"uri\":\"data:application/octet-stream;base64,%s\"}",
                            size, gltf_base64(arena, bytes, (size_t)size));
    gltf_accept(arena, &d, b);
}

// The ring may begin at any corner.
static void expect_floor(const Building *b, const char *what) {
    static const Vec3 FLOOR[4] = {{0, 0, 0}, {4, 0, 0}, {4, 2, 0}, {0, 2, 0}};
    cr_assert(b->polygon_count == 1 && b->vertex_count == 4, "%s: %d polygons", what, b->polygon_count);
    // Tolerance: factors such as 0.01 are rounded.
    const double close = 1e-9;
    int first = 0;
    while (first < 3 && vec3_length(b->vertices[first]) > close) first++;
    for (int i = 0; i < 4; i++) {
        Vec3 v = b->vertices[(first + i) % 4];
        cr_expect(vec3_length(vec3_sub(v, FLOOR[i])) < close, "%s: corner %d at (%g, %g, %g)", what, i, v.x,
                  v.y, v.z);
    }
}

static const char NODE[] = "[{\"mesh\":0}]";

// Positions of every component type, normalised or not, interleaved, sparse over bytes and over nothing.
Test(gltf, accessors) {
    static const char VIEW[] = "[{\"buffer\":0,\"byteLength\":12}]",
                      VIEW24[] = "[{\"buffer\":0,\"byteLength\":24}]",
                      VIEW48[] = "[{\"buffer\":0,\"byteLength\":48}]";
    static const Floor CASES[] = {
        {"i8", "[{\"bufferView\":0,\"componentType\":5120,\"count\":4,\"type\":\"VEC3\"}]", VIEW,
         "000000 040000 0400FE 0000FE", NODE, 6, false},
        {"u8", "[{\"bufferView\":0,\"componentType\":5121,\"count\":4,\"type\":\"VEC3\"}]", VIEW,
         "000000 040000 040200 000200", "[{\"mesh\":0,\"rotation\":[-1,0,0,1]}]", 6, false},
        {"i8 normalised",
         "[{\"bufferView\":0,\"componentType\":5120,\"normalized\":true,\"count\":4,\"type\":\"VEC3\"}]",
         VIEW, "000000 7F0000 7F0080 000081", "[{\"mesh\":0,\"scale\":[4,1,2]}]", 6, false},
        {"u8 normalised",
         "[{\"bufferView\":0,\"componentType\":5121,\"normalized\":true,\"count\":4,\"type\":\"VEC3\"}]",
         VIEW, "000000 FF0000 FFFF00 00FF00",
         "[{\"mesh\":0,\"matrix\":[4,0,0,0, 0,0,-2,0, 0,1,0,0, 0,0,0,1]}]", 6, false},
        {"u16 normalised",
         "[{\"bufferView\":0,\"componentType\":5123,\"normalized\":true,\"count\":4,\"type\":\"VEC3\"}]",
         VIEW24, "000000000000 FFFF00000000 FFFFFFFF0000 0000FFFF0000",
         "[{\"mesh\":0,\"matrix\":[4,0,0,0, 0,0,-2,0, 0,1,0,0, 0,0,0,1]}]", 6, false},
        {"i16", "[{\"bufferView\":0,\"componentType\":5122,\"count\":4,\"type\":\"VEC3\"}]", VIEW24,
         "000000000000 900100000000 9001000038FF 0000000038FF", "[{\"mesh\":0,\"scale\":[0.01,0.01,0.01]}]",
         6, false},
        {"f32", "[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}]", VIEW48,
         "000000000000000000000000 000080400000000000000000 0000804000000000000000C0 "
         "0000000000000000000000C0",
         NODE, 6, false},
        {"stride",
         "[{\"bufferView\":0,\"byteOffset\":1,\"componentType\":5120,\"count\":4,\"type\":\"VEC3\"}]",
         "[{\"buffer\":0,\"byteOffset\":2,\"byteLength\":28,\"byteStride\":8}]",
         "EEEE 55 000000 55555555 55 040000 55555555 55 0400FE 55555555 55 0000FE", NODE, 6, false},
        {"sparse over bytes",
         "[{\"bufferView\":0,\"componentType\":5120,\"count\":4,\"type\":\"VEC3\",\"sparse\":{\"count\":2,"
         "\"indices\":{\"bufferView\":1,\"componentType\":5121},\"values\":{\"bufferView\":2}}}]",
         "[{\"buffer\":0,\"byteLength\":12},{\"buffer\":0,\"byteOffset\":12,\"byteLength\":2},"
         "{\"buffer\":0,\"byteOffset\":14,\"byteLength\":6}]",
         "000000 070707 0400FE 090909 0103 040000 0000FE", NODE, 6, false},
        {"sparse over nothing",
         "[{\"componentType\":5120,\"count\":4,\"type\":\"VEC3\",\"sparse\":{\"count\":3,"
         "\"indices\":{\"bufferView\":0,\"componentType\":5123},\"values\":{\"bufferView\":0,\"byteOffset\":"
         "6}}}]",
         "[{\"buffer\":0,\"byteLength\":15}]", "0100 0200 0300 040000 0400FE 0000FE", NODE, 6, false},
    };
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Arena arena = {0};
        Building b;
        accept_floor(&arena, &CASES[i], &b);
        expect_floor(&b, CASES[i].what);
        arena_free(&arena);
    }
}

// Lists, strips and fans of triangles, with indices of each type or none, are the same floor.
Test(gltf, primitives) {
    static const struct {
        const char *hex;
        int mode, type, count;
    } CASES[] = {{"00 01 02 00 02 03", 4, 5121, 6},
                 {"0000 0100 0200 0000 0200 0300", 4, 5123, 6},
                 {"00000000 01000000 02000000 00000000 02000000 03000000", 4, 5125, 6},
                 {"00 01 03 02", 5, 5121, 4},
                 {"00 01 02 03", 6, 5121, 4},
                 {"00", 6, 0, 0}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Arena arena = {0};
        Building b;
        Floor f = {.what = CASES[i].hex, .nodes = NODE, .mode = CASES[i].mode, .indexed = CASES[i].type != 0};
        f.accessors =
            arena_format(&arena,
                         "[{\"bufferView\":0,\"componentType\":5120,\"count\":4,\"type\":\"VEC3\"},"
                         "{\"bufferView\":1,\"componentType\":%d,\"count\":%d,\"type\":\"SCALAR\"}]",
                         CASES[i].type, CASES[i].count);
        f.views = "[{\"buffer\":0,\"byteLength\":12},{\"buffer\":0,\"byteOffset\":12,\"byteLength\":24}]";
        f.hex = arena_format(&arena, "000000 040000 0400FE 0000FE %s %s", CASES[i].hex,
                             "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00");
        accept_floor(&arena, &f, &b);
        expect_floor(&b, CASES[i].hex);
        arena_free(&arena);
    }
}
