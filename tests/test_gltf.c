// test_gltf.c - the glTF reader: containers, accessors, the node forest, looks, lights and cameras, and every fault.
#include <criterion/criterion.h>
#include <png.h>
#include <stdio.h>

#include "engine/core/text.h"
#include "tests/soups.h"
#include "tests/support.h"

extern const MapsReader MAPS_READER_GLTF, MAPS_READER_QUADS;

// The room of soups.h, y up: 8 positions in single precision, then 36 indices of u16.
enum { POSITIONS = 96, INDICES = 72, BIN = POSITIONS + INDICES };

static void room_bytes(unsigned char out[BIN]) {
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
    memcpy(out, position, POSITIONS);
    memcpy(out + POSITIONS, index, INDICES);
}

static char *base64(Arena *arena, const unsigned char *data, size_t size) {
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

// What a document of the room is made of; a test replaces what it is about.
typedef struct Document {
    const char *asset, *head, *scene, *nodes, *mesh, *accessors, *views, *buffer;
} Document;

static Document usual(void) {
    return (Document){
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

static char *document(Arena *arena, const Document *d) {
    unsigned char bytes[BIN];
    room_bytes(bytes);
    const char *buffer = d->buffer ? d->buffer
                                   : arena_format(arena, "{\"byteLength\":168,\"uri\":\"data:;base64,%s\"}",
                                                  base64(arena, bytes, BIN));
    return arena_format(arena,
                        "{\"asset\":%s,%s%s,\"nodes\":%s,\"meshes\":[%s],\"accessors\":%s,\"bufferViews\":%s,"
                        "\"buffers\":[%s]}",
                        d->asset, d->head, d->scene, d->nodes, d->mesh, d->accessors, d->views, buffer);
}

static void accept(Arena *arena, const Document *d, Building *b) {
    soups_accept(&MAPS_READER_GLTF, "t.gltf", document(arena, d), arena, b);
}

static void refuse(const Document *d, const char *expected) {
    Arena arena = {0};
    soups_refuse(&MAPS_READER_GLTF, "t.gltf", document(&arena, d), expected);
    arena_free(&arena);
}

static void put_word(unsigned char *at, size_t value) {
    uint32_t word = (uint32_t)value;
    memcpy(at, &word, sizeof word);
}

// A .glb of the text and the room's bytes.
static Bytes binary(Arena *arena, const char *json) {
    size_t text = (strlen(json) + 3) / 4 * 4, size = 12 + 8 + text + 8 + BIN;
    unsigned char *out = arena_alloc(arena, size, 1);
    put_word(out, 0x46546C67), put_word(out + 4, 2), put_word(out + 8, size);
    put_word(out + 12, text), put_word(out + 16, 0x4E4F534A);
    memset(out + 20, ' ', text);
    memcpy(out + 20, json, strlen(json));
    put_word(out + 20 + text, BIN), put_word(out + 24 + text, 0x004E4942);
    room_bytes(out + 28 + text);
    return (Bytes){out, size};
}

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
    Document d = usual();
    accept(&arena, &d, &inside);
    soups_expect_same(&quads, &inside);
    cr_assert_eq(inside.object_count, 1);
    cr_expect_str_eq(inside.objects[0].name, "room");
    cr_expect_eq(soups_notes(&inside, "reflect more than 0.85"), 1, "the default material is white");

    const char *folder = support_folder(&arena), *path = arena_format(&arena, "%s/r.gltf", folder);
    unsigned char bytes[BIN];
    room_bytes(bytes);
    cr_assert(file_write(arena_format(&arena, "%s/a b.bin", folder), bytes, BIN, &error), "%s", error.text);
    d.buffer = "{\"byteLength\":168,\"uri\":\"a%20b.bin\"}";
    const char *text = document(&arena, &d);
    cr_assert(file_write(path, text, strlen(text), &error), "%s", error.text);
    cr_assert(maps_read(path, &arena, &beside, &error), "%s", error.text);
    soups_expect_same(&quads, &beside);
    float wider = 0.5f;
    memcpy(bytes, &wider, sizeof wider);
    cr_assert(file_write(arena_format(&arena, "%s/a b.bin", folder), bytes, BIN, &error), "%s", error.text);
    cr_assert(maps_read(path, &arena, &again, &error), "%s", error.text);
    cr_expect_neq(beside.hash, again.hash, "other bytes beside make another building");

    d.buffer = "{\"byteLength\":168}";
    Bytes file = binary(&arena, document(&arena, &d));
    cr_assert(soups_read(&MAPS_READER_GLTF, "t.glb", file.data, file.size, &arena, &glb, &error), "%s",
              error.text);
    soups_expect_same(&quads, &glb);
    arena_free(&arena);
}

// Chunks that lie about their length or kind are refused with their byte.
Test(gltf, broken_containers) {
    Arena arena = {0};
    Document d = usual();
    d.buffer = "{\"byteLength\":168}";
    Bytes file = binary(&arena, document(&arena, &d));
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
        put_word(copy + CASES[i].at, CASES[i].value);
        Building b;
        Error error = {""};
        cr_expect(!soups_read(&MAPS_READER_GLTF, "t.glb", copy, file.size, &arena, &b, &error));
        cr_expect(strstr(error.text, CASES[i].expected), "%s\n%s", error.text, CASES[i].expected);
    }
    // Another kind of second chunk is no BIN chunk; so the first buffer has no bytes.
    put_word(file.data + 24 + text, 7);
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
    Document d = usual();
    d.accessors = f->accessors, d.views = f->views, d.nodes = f->nodes;
    d.mesh = arena_format(arena, "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"mode\":%d%s}]}",
                          f->mode, f->indexed ? ",\"indices\":1" : "");
    d.buffer = arena_format(arena, "{\"byteLength\":%d,\"uri\":\"data:application/octet-stream;base64,%s\"}",
                            size, base64(arena, bytes, (size_t)size));
    accept(arena, &d, b);
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

// ---- the scene

// Where the room's first wall, its floor, came to lie, and which way it faces.
static Plane floor_plane(const Building *b, int object, Vec3 *low) {
    const Polygon *p = &b->polygons[b->objects[object].first_polygon];
    *low = b->vertices[p->first_vertex];
    for (int i = 1; i < p->vertex_count; i++) {
        Vec3 v = b->vertices[p->first_vertex + i];
        *low = vec3(fmin(low->x, v.x), fmin(low->y, v.y), fmin(low->z, v.z));
    }
    return plane_of_polygon(&b->vertices[p->first_vertex], p->vertex_count);
}

// Ways multiply down the tree, matrices are column by column, mirrors keep walls facing inwards, and a mesh stands at
// each node that names it. y up becomes z up.
Test(gltf, nodes) {
    Arena arena = {0};
    Document d = usual();
    d.scene = "\"scene\":1,\"scenes\":[{\"nodes\":[]},{\"nodes\":[0,5]}]";
    d.nodes = "[{\"children\":[1,2],\"translation\":[10,0,0]},"
              "{\"mesh\":0,\"name\":\"raised\",\"translation\":[0,3,0]},"
              "{\"children\":[3,4],\"scale\":[2,2,2]},"
              "{\"mesh\":0,\"name\":\"scaled\",\"translation\":[1,1,1]},"
              "{\"mesh\":0,\"name\":\"mirrored\",\"matrix\":[-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]},"
              "{\"mesh\":0,\"rotation\":[0,0.7071067811865476,0,0.7071067811865476]}]";
    d.mesh = "{\"name\":\"hall\",\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}";
    Building b;
    accept(&arena, &d, &b);
    cr_assert_eq(b.object_count, 4);
    static const struct {
        const char *name;
        Vec3 low;
    } EXPECTED[] = {
        {"raised", {10, 0, 3}}, {"scaled", {12, -2, 2}}, {"mirrored", {2, 0, 0}}, {"hall", {-3, 0, 0}}};
    for (int i = 0; i < 4; i++) {
        Vec3 low;
        Plane plane = floor_plane(&b, i, &low);
        cr_expect_str_eq(b.objects[i].name, EXPECTED[i].name);
        // Tolerance: the square root of one half is rounded.
        cr_expect(vec3_length(vec3_sub(low, EXPECTED[i].low)) < 1e-9, "%s at (%g, %g, %g)", EXPECTED[i].name,
                  low.x, low.y, low.z);
        cr_expect_float_eq(plane.n.z, 1, 1e-9, "%s: its floor looks up", EXPECTED[i].name);
    }
    cr_expect_eq(soups_notes(&b, "1 more scenes were left out"), 1);
    arena_free(&arena);
}

// Lamps shine in watts and cameras look where the file says, in a building with z up.
Test(gltf, lights_and_cameras) {
    Arena arena = {0};
    Document d = usual();
    d.head =
        "\"extensionsRequired\":[\"KHR_lights_punctual\"],"
        "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\",\"intensity\":683,"
        "\"color\":[1,0.5,0]},{\"type\":\"spot\",\"intensity\":683,\"spot\":{\"outerConeAngle\":1.5707963},"
        "\"name\":\"lamp\"},{\"type\":\"directional\",\"intensity\":100000}]}},"
        "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"aspectRatio\":1,\"znear\":1}},"
        "{\"type\":\"orthographic\",\"name\":\"plan\"}],";
    d.scene = "\"scenes\":[{\"nodes\":[0,1,2,3,4,5]}]";
    d.nodes =
        "[{\"mesh\":0},"
        "{\"name\":\"bulb\",\"translation\":[1,2,-3],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},"
        "{\"extensions\":{\"KHR_lights_punctual\":{\"light\":1}}},"
        "{\"extensions\":{\"KHR_lights_punctual\":{\"light\":2}}},"
        "{\"name\":\"door\",\"camera\":0,\"translation\":[1,1.6,-1]},"
        "{\"camera\":1,\"rotation\":[-0.3826834323650898,0,0,0.9238795325112867]}]";
    Building b;
    accept(&arena, &d, &b);
    cr_assert_eq(b.light_count, 2);
    const Light *bulb = &b.lights[0], *lamp = &b.lights[1];
    cr_expect_str_eq(bulb->name, "bulb");
    cr_expect_str_eq(lamp->name, "lamp");
    cr_expect(bulb->position.x == 1 && bulb->position.y == 3 && bulb->position.z == 2);
    // 683 cd are 1 W a steradian. Tolerance: single precision; half a sphere's angle has eight digits.
    cr_expect_float_eq((double)bulb->flux.r, 4 * M_PI, 1e-5);
    cr_expect_float_eq((double)bulb->flux.g, 2 * M_PI, 1e-5);
    cr_expect_float_eq((double)lamp->flux.b, 2 * M_PI, 1e-5);
    cr_expect_eq(soups_notes(&b, "1 directional lights"), 1);
    cr_assert_eq(b.viewpoint_count, 2);
    const Viewpoint *door = &b.viewpoints[0], *plan = &b.viewpoints[1];
    cr_expect_str_eq(door->name, "door");
    cr_expect_float_eq(door->yaw, M_PI / 2, 1e-12, "-z of the file is +y of the building");
    cr_expect_float_eq(door->fov, 1, 1e-12);
    cr_expect_float_eq(plan->pitch, -M_PI / 4, 1e-12);
    cr_expect(b.start.x == 1 && b.start.y == 1 && b.start.z == 1.6, "a walk begins at the first camera");
    arena_free(&arena);
}

static Bytes chequer(Arena *arena) {
    static const unsigned char PIXELS[] = {0, 0, 0, 255, 255, 255, 255, 255};
    png_image image = {.version = PNG_IMAGE_VERSION, .width = 2, .height = 1, .format = PNG_FORMAT_RGBA};
    png_alloc_size_t size = 0;
    cr_assert(png_image_write_to_memory(&image, NULL, &size, 0, PIXELS, 0, NULL));
    Bytes out = {arena_alloc(arena, size, 1), size};
    cr_assert(png_image_write_to_memory(&image, out.data, &size, 0, PIXELS, 0, NULL));
    return out;
}

// Colours, what is seen through, what shines, and textures by their mean.
Test(gltf, materials) {
    static const struct {
        const char *material;
        float red, alpha, emission;
    } CASES[] = {
        {"\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.2,0.1,0.3]}", 0.5f, 1, 0},
        {"\"alphaMode\":\"BLEND\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.2,0.1,0.25]}", 0.5f,
         0.25f, 0},
        {"\"alphaMode\":\"MASK\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.2,0.1,0.75]}", 0.5f, 1,
         0},
        {"\"alphaMode\":\"MASK\",\"alphaCutoff\":0.8,\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1,0."
         "75]}",
         MAPS_MAX_REFLECTANCE, 0, 0},
        {"\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0},\"baseColorFactor\":[0.8,1,1,1]}",
         0.8f * MAPS_MAX_REFLECTANCE / 2, 1, 0},
        {"\"alphaMode\":\"MASK\",\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}",
         MAPS_MAX_REFLECTANCE / 2, 0.5f, 0},
        {"\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":1},\"baseColorFactor\":[0.4,1,1,1]}",
         0.4f, 1, 0},
        {"\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":0.75}},"
         "\"pbrMetallicRoughness\":{\"baseColorFactor\":[0,0,0,1]}",
         0, 0.25f, 0},
        {"\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{\"diffuseFactor\":[0.6,0,0,1]}}", 0.6f, 1,
         0},
        {"\"emissiveFactor\":[0.5,0,0],\"pbrMetallicRoughness\":{\"baseColorFactor\":[0,0,0,1]},"
         "\"extensions\":{"
         "\"KHR_materials_emissive_strength\":{\"emissiveStrength\":1366}}",
         0, 1, (float)M_PI},
    };
    Arena arena = {0};
    Bytes png = chequer(&arena);
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Document d = usual();
        d.head = arena_format(
            &arena,
            "\"materials\":[{\"name\":\"paint\",%s}],\"textures\":[{\"source\":0},{\"source\":1}],"
            "\"images\":[{\"uri\":\"data:image/png;base64,%s\"},{\"bufferView\":0}],",
            CASES[i].material, base64(&arena, png.data, png.size));
        d.mesh = "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]}";
        Building b;
        accept(&arena, &d, &b);
        cr_assert_eq(b.material_count, 1);
        const Material *m = &b.materials[0];
        cr_expect_str_eq(m->name, "paint");
        // Tolerance: single precision.
        cr_expect(fabsf(m->reflectance.r - CASES[i].red) < 1e-6f &&
                      fabsf(m->alpha - CASES[i].alpha) < 1e-6f &&
                      fabsf(m->emission.r - CASES[i].emission) < 1e-5f,
                  "%s: %g %g %g", CASES[i].material, (double)m->reflectance.r, (double)m->alpha,
                  (double)m->emission.r);
    }
    static const char *const LOST[] = {"\"bufferView\":0", "\"uri\":\"nothing-here.png\"",
                                       "\"uri\":\"../up.png\""};
    for (size_t i = 0; i < sizeof LOST / sizeof *LOST; i++) {
        Document d = usual();
        d.head =
            arena_format(&arena,
                         "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}],"
                         "\"textures\":[{\"source\":0}],\"images\":[{%s}],",
                         LOST[i]);
        d.mesh = "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]}";
        Building b;
        accept(&arena, &d, &b);
        cr_expect_eq(soups_notes(&b, "1 textures are missing or could not be decoded"), 1);
    }
    arena_free(&arena);
}

// Points and lines are no polygons; what is left of a mesh counts.
Test(gltf, leaves_out) {
    Arena arena = {0};
    Document d = usual();
    d.mesh = "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"mode\":1},{\"attributes\":{"
             "\"POSITION\":0},\"indices\":1,\"targets\":[{}]}]}";
    Building b;
    accept(&arena, &d, &b);
    cr_expect_eq(b.polygon_count, 6);
    cr_expect_eq(soups_notes(&b, "1 primitives of points or lines"), 1);
    cr_expect_eq(soups_notes(&b, "as at rest"), 1);
    arena_free(&arena);
}

// ---- faults

typedef struct Case {
    const char *text, *expected;
} Case;

Test(gltf, faults_of_the_document) {
    static const Case ASSETS[] = {
        {"{\"version\":\"1.0\"}", "asset.version: is 1.0 (allowed: 2.0 and later 2)"},
        {"{\"version\":2}", "asset.version: is a number (allowed: a string)"},
        {"{\"version\":\"2.0\",\"minVersion\":\"2.1\"}", "asset.minVersion: is 2.1"},
        {"7", "asset: is a number (allowed: an object)"}};
    static const Case HEADS[] = {
        {"\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],",
         "`KHR_draco_mesh_compression` is not read"},
        {"\"extensionsRequired\":[\"EXT_meshopt_compression\"],", "`EXT_meshopt_compression` is not read"},
        {"\"extensionsRequired\":[7],", "`what is no string` is not read"},
        {"\"materials\":7,", "materials: is a number (allowed: an array)"},
        {"\"a\":1,\"a\":2,", "duplicate object key"},
        {"\"a\":1e400,", "real number overflow"},
        {"\"a\":99999999999999999999,", "too big integer"},
        {"\"a\":NaN,", "line 1 of the JSON"},
        {"\"a\":\"\\u0000\",", "\\u0000 is not allowed"},
    };
    static const Case BUFFERS[] = {
        {"{\"byteLength\":169,\"uri\":\"data:;base64,AAAA\"}",
         "buffers[0].byteLength: is 169 (the buffer has 3 bytes)"},
        {"{\"byteLength\":2147483648}", "buffers[0].byteLength: is 2147483648 (allowed 1 to 2147483647)"},
        {"{\"byteLength\":-1}", "buffers[0].byteLength: is -1"},
        {"{\"byteLength\":168}", "buffers[0].uri: is missing"},
        {"{\"uri\":\"x.bin\"}", "buffers[0].byteLength: is missing"},
        {"{\"byteLength\":168,\"uri\":\"data:,AAAA\"}", "allowed of data: `data:TYPE;base64,...`"},
        {"{\"byteLength\":168,\"uri\":\"data:;base64,A*AA\"}", "character 1 of the data is byte 42"},
        {"{\"byteLength\":168,\"uri\":\"../x.bin\"}",
         "refers to the file `../x.bin` (allowed: files in its own folder"},
        {"{\"byteLength\":168,\"uri\":\"a/../../x.bin\"}", "(allowed: files in its own folder"},
        {"{\"byteLength\":168,\"uri\":\"%2e%2E/x.bin\"}", "refers to the file `../x.bin`"},
        {"{\"byteLength\":168,\"uri\":\"/etc/passwd\"}", "refers to the file `/etc/passwd`"},
        {"{\"byteLength\":168,\"uri\":\"..\\\\x.bin\"}", "refers to the file `..\\x.bin` (allowed"},
        {"{\"byteLength\":168,\"uri\":\"\"}", "refers to the file ``"},
        {"{\"byteLength\":168,\"uri\":\"a%00b\"}", "has `%00` (allowed: %01 to %FF)"},
        {"{\"byteLength\":168,\"uri\":\"nothing-here.bin\"}", "nothing-here.bin"},
    };
    for (size_t i = 0; i < sizeof ASSETS / sizeof *ASSETS; i++) {
        Document d = usual();
        d.asset = ASSETS[i].text;
        refuse(&d, ASSETS[i].expected);
    }
    for (size_t i = 0; i < sizeof HEADS / sizeof *HEADS; i++) {
        Document d = usual();
        d.head = HEADS[i].text;
        refuse(&d, HEADS[i].expected);
    }
    for (size_t i = 0; i < sizeof BUFFERS / sizeof *BUFFERS; i++) {
        Document d = usual();
        d.buffer = BUFFERS[i].text;
        refuse(&d, BUFFERS[i].expected);
    }
}

Test(gltf, faults_of_views) {
    static const Case VIEWS[] = {
        {"[{\"byteLength\":96}]", "bufferViews[0].buffer: is missing"},
        {"[{\"buffer\":1,\"byteLength\":96}]", "bufferViews[0].buffer: is 1 (allowed 0 to 0)"},
        {"[{\"buffer\":0}]", "bufferViews[0].byteLength: is missing"},
        {"[{\"buffer\":0,\"byteLength\":169}]", "bufferViews[0]: bytes 0 to 169 (its buffer has 168)"},
        {"[{\"buffer\":0,\"byteOffset\":2147483647,\"byteLength\":2147483647}]",
         "bufferViews[0]: bytes 2147483647 to 4294967294"},
        {"[{\"buffer\":0,\"byteLength\":96,\"byteStride\":3}]",
         "bufferViews[0].byteStride: is 3 (allowed 4 to 252)"},
        {"[{\"buffer\":0,\"byteLength\":96,\"byteStride\":4}]",
         "accessors[0]: elements of 12 bytes every 4 bytes (allowed: 12 or more)"},
        {"[{\"buffer\":0,\"byteLength\":95}]",
         "accessors[0].count: 8 elements from byte 0 end at byte 96 (its view has 95)"},
        {"[7]", "bufferViews[0]: is a number (allowed: an object)"},
        {"[]", "accessors[0].bufferView: refers to the document's bufferViews (it has none)"},
        {"[{\"buffer\":0,\"byteLength\":96}]", "accessors[1].bufferView: is 1 (allowed 0 to 0)"},
        {"[{\"buffer\":0,\"byteLength\":96},{\"buffer\":0,\"byteOffset\":94,\"byteLength\":72}]",
         "meshes[0].primitives[0].indices: index 0 is 4"},
    };
    for (size_t i = 0; i < sizeof VIEWS / sizeof *VIEWS; i++) {
        Document d = usual();
        d.views = VIEWS[i].text;
        refuse(&d, VIEWS[i].expected);
    }
}

Test(gltf, faults_of_accessors) {
    static const Case ACCESSORS[] = {
        {"[]", "attributes.POSITION: refers to the document's accessors (it has none)"},
        {"[{\"bufferView\":0,\"componentType\":5124,\"count\":8,\"type\":\"VEC3\"}]",
         "accessors[0].componentType: is 5124 (allowed 5120 to 5123, 5125, 5126)"},
        {"[{\"bufferView\":0,\"componentType\":5127,\"count\":8,\"type\":\"VEC3\"}]",
         "accessors[0].componentType: is"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":8,\"type\":\"VEC2\"}]",
         "accessors[0].type: is VEC2 (allowed here: VEC3)"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":8}]", "accessors[0].type: is missing"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\"}]", "accessors[0].count: is missing"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":0,\"type\":\"VEC3\"}]",
         "accessors[0].count: is 0"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":2147483648,\"type\":\"VEC3\"}]",
         "accessors[0].count: is 2147483648 (allowed 1 to 4194304)"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":1.5,\"type\":\"VEC3\"}]",
         "accessors[0].count: is 1.5"},
        {"[{\"componentType\":5126,\"count\":8,\"type\":\"VEC3\"}]", "neither a bufferView nor sparse"},
        {"[{\"bufferView\":0,\"byteOffset\":1,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\"}]",
         "end at byte 97 (its view has 96)"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"normalized\":true,\"count\":8,\"type\":\"VEC3\"}]",
         "accessors[0].normalized: is true"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\",\"sparse\":{\"count\":9,"
         "\"indices\":{},\"values\":{}}}]",
         "accessors[0].sparse.count: is 9 (allowed 1 to 8)"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\",\"sparse\":{\"count\":1}}]",
         "accessors[0].sparse: lacks indices or values"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\",\"sparse\":{\"count\":2,"
         "\"indices\":{"
         "\"bufferView\":0,\"componentType\":5121},\"values\":{\"bufferView\":0}}}]",
         "accessors[0].sparse.indices: index 1 is 0 (allowed 1 to 7: they increase)"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\",\"sparse\":{\"count\":1,"
         "\"indices\":{"
         "\"bufferView\":0,\"componentType\":5126},\"values\":{\"bufferView\":0}}}]",
         "accessors[0].sparse.indices.componentType: is 5126"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\"},{\"bufferView\":1,"
         "\"componentType\":5122,\"count\":36,\"type\":\"SCALAR\"}]",
         "accessors[1].componentType: is 5122 (allowed of indices"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":7,\"type\":\"VEC3\"},{\"bufferView\":1,"
         "\"componentType\":5123,\"count\":36,\"type\":\"SCALAR\"}]",
         "meshes[0].primitives[0].indices: index 6 is 7 (allowed 0 to 6)"},
        {"[{\"bufferView\":0,\"componentType\":5126,\"count\":8,\"type\":\"VEC3\"},{\"bufferView\":1,"
         "\"componentType\":5123,\"count\":35,\"type\":\"SCALAR\"}]",
         "has 35 corners (allowed of triangles: a multiple of 3)"},
    };
    for (size_t i = 0; i < sizeof ACCESSORS / sizeof *ACCESSORS; i++) {
        Document d = usual();
        d.accessors = ACCESSORS[i].text;
        refuse(&d, ACCESSORS[i].expected);
    }
    // Not a number where a position should be: the sign of the first float's bytes, all set.
    Document d = usual();
    Arena arena = {0};
    unsigned char bytes[BIN];
    room_bytes(bytes);
    memset(bytes + 4, 0xFF, 4);
    d.buffer =
        arena_format(&arena, "{\"byteLength\":168,\"uri\":\"data:;base64,%s\"}", base64(&arena, bytes, BIN));
    refuse(&d, "accessors[0]: number 1 of element 0 is not finite");
    arena_free(&arena);
}

Test(gltf, faults_of_the_scene) {
    static const Case NODES[] = {
        {"[]", "scenes[0].nodes[0]: refers to the document's nodes (it has none)"},
        {"[{\"mesh\":1}]", "nodes[0].mesh: is 1 (allowed 0 to 0)"},
        {"[{\"mesh\":-1}]", "nodes[0].mesh: is -1"},
        {"[{\"mesh\":\"0\"}]", "nodes[0].mesh: is a string (allowed: a number from 0 to 0)"},
        {"[{\"children\":[1]},{\"children\":[2]},{\"children\":[1]}]",
         "nodes[2].children: node 1 is a child of node 0 too (allowed: one parent)"},
        {"[{},{\"children\":[2]},{\"children\":[3]},{\"children\":[1]}]",
         "is its own ancestor (allowed: no cycles)"},
        {"[{\"children\":[0]}]", "nodes[0]: is its own ancestor"},
        {"[{},{\"children\":[0]}]", "scenes[0].nodes: node 0 is a child"},
        {"[{\"children\":[9]}]", "nodes[0].children[0]: is 9 (allowed 0 to 0)"},
        {"[{\"children\":7}]", "nodes[0].children: is a number (allowed: an array)"},
        {"[{\"matrix\":[1,2,3]}]", "nodes[0].matrix: has 3 numbers (allowed: 16)"},
        {"[{\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,2]}]",
         "nodes[0].matrix: ends its columns with 0, 0, 0, 2"},
        {"[{\"translation\":[1,2,\"3\"]}]", "nodes[0].translation[2]: is a string"},
        {"[{\"translation\":[1,2,1e300]}]", "nodes[0].translation[2]: is 1e+300 (allowed -1e+15 to 1e+15)"},
        {"[{\"rotation\":[0,0,0,0]}]", "nodes[0].rotation: has length 0 (allowed: 1)"},
        {"[{\"mesh\":0,\"translation\":[1e9,0,0]}]", "nodes[0]: a corner of its mesh lies at (1e+09"},
        {"[{\"mesh\":0,\"scale\":[0,0,0]}]", "t.gltf: holds no polygon that has an area"},
        {"[{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{}}}]",
         "EXT_mesh_gpu_instancing: is not read"},
        {"[{\"camera\":0}]", "nodes[0].camera: refers to the document's cameras (it has none)"},
        {"[{\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}]", "KHR_lights_punctual.light: is 0"},
        {"[{\"extensions\":7}]", "nodes[0].extensions: is a number (allowed: an object)"},
    };
    static const Case MESHES[] = {
        {"{}", "meshes[0].primitives: is missing or empty"},
        {"{\"primitives\":[{}]}", "meshes[0].primitives[0].attributes.POSITION: is missing"},
        {"{\"primitives\":[{\"attributes\":{\"POSITION\":9}}]}",
         "meshes[0].primitives[0].attributes.POSITION: is 9 (allowed 0 to 1)"},
        {"{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"mode\":7}]}",
         "primitives[0].mode: is 7 (allowed 0 to 6)"},
        {"{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}",
         "has 8 corners (allowed of triangles: a multiple of 3)"},
        {"{\"primitives\":[{\"attributes\":{\"POSITION\":1}}]}",
         "accessors[1].type: is SCALAR (allowed here: VEC3)"},
        {"{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":0}]}", "accessors[0].type: is VEC3"},
        {"{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}",
         "the document's materials (it has none)"},
    };
    static const Case MATERIALS[] = {
        {"\"alphaMode\":\"CLEAR\"", "materials[0].alphaMode: is CLEAR (allowed: OPAQUE, MASK, BLEND)"},
        {"\"pbrMetallicRoughness\":{\"baseColorFactor\":[2,0,0,1]}",
         "materials[0].pbrMetallicRoughness.baseColorFactor[0]: is 2 (allowed 0 to 1)"},
        {"\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1]}", "has 3 numbers (allowed: 4)"},
        {"\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}",
         "the document's textures (it has none)"},
        {"\"emissiveFactor\":[0,0,-1]", "materials[0].emissiveFactor[2]: is -1"},
    };
    Arena arena = {0};
    for (size_t i = 0; i < sizeof NODES / sizeof *NODES; i++) {
        Document d = usual();
        d.nodes = NODES[i].text;
        refuse(&d, NODES[i].expected);
    }
    for (size_t i = 0; i < sizeof MESHES / sizeof *MESHES; i++) {
        Document d = usual();
        d.mesh = MESHES[i].text;
        refuse(&d, MESHES[i].expected);
    }
    for (size_t i = 0; i < sizeof MATERIALS / sizeof *MATERIALS; i++) {
        Document d = usual();
        d.mesh = "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":0}]}";
        d.head = arena_format(&arena, "\"materials\":[{%s}],", MATERIALS[i].text);
        refuse(&d, MATERIALS[i].expected);
    }
    Document d = usual();
    d.scene = "\"scene\":0,\"scenes\":[{\"nodes\":[0,0]}]";
    refuse(&d, "scenes[0].nodes: node 0 is named twice");
    d.scene = "\"scene\":1,\"scenes\":[{\"nodes\":[0]}]";
    refuse(&d, "scene: is 1 (allowed 0 to 0)");
    arena_free(&arena);
}

// A tree of nodes deeper than any stack of calls would bear.
Test(gltf, deep_tree) {
    Arena arena = {0};
    Text nodes = {.arena = &arena};
    enum { DEPTH = 100000 };
    text_append(&nodes, "[");
    for (int i = 0; i < DEPTH; i++) text_append(&nodes, "{\"children\":[%d]},", i + 1);
    text_append(&nodes, "{\"mesh\":0}]");
    Document d = usual();
    d.nodes = nodes.data;
    Building b;
    accept(&arena, &d, &b);
    cr_expect_eq(b.polygon_count, 6);
    arena_free(&arena);
}

// What the fuzzer begins with, which has something of everything.
Test(gltf, survives_damage, .timeout = 300) {
    static const char *const SEEDS[] = {"tests/seeds/room.gltf", "tests/seeds/room.glb"};
    for (size_t i = 0; i < sizeof SEEDS / sizeof *SEEDS; i++) {
        Arena arena = {0};
        Bytes seed = support_read(&arena, SEEDS[i]);
        Building b;
        Error error = {""};
        cr_assert(maps_read(SEEDS[i], &arena, &b, &error), "%s", error.text);
        cr_expect(b.polygon_count == 12 && b.light_count == 1 && b.viewpoint_count == 1);
        soups_damage(&MAPS_READER_GLTF, SEEDS[i], seed.data, seed.size, 17 + i, support_count(6000, 600000));
        arena_free(&arena);
    }
}
