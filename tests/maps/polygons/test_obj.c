// test_obj.c - OBJ and MTL models, and the mean colour of images.
#include <criterion/criterion.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "engine/core/random.h"
#include "maps/building/texture.h"
#include "maps/polygons/obj.h"
#include "tests/support/support.h"

static Bytes text_bytes(Arena *arena, const char *text) {
    return (Bytes){(unsigned char *)arena_string(arena, text), strlen(text)};
}

static bool read_text(Arena *arena, const char *text, const ObjFiles *files, ObjModel *model, Error *error) {
    return obj_read(text_bytes(arena, text), "model", files, arena, model, error);
}

// Every way to write a corner means the vertex it says; bad faces go, good ones stay.
Test(obj, reads_corners_of_every_form_and_skips_bad_faces) {
    Arena arena = {0};
    ObjModel m;
    Error error;
    const char *text = "# comment\r\n"
                       "v 0 0 0\nv 1 0 0 1.0\nv\t1 2 0\r\nv 0 2 0\n"
                       "vt 0 0\nvn 0 0 1\n"
                       "f 1 2 3\n"
                       "g first door\nf 1/1 2/1 3/1 4/1\nf 1//1 2//1 3//1\n"
                       "o second\nusemtl red\nf 1/1/1 2/1/1 \\\n 3/1/1\nf -4 -3 -2 -1 # all\n"
                       "f 1 2\nf 1 2 5\nf 0 1 2\nf -5 1 2\nf a b c\n"
                       "v nan 0 0\nf 1 2 5\nv 7 7 7\nf 1 2 6\nunknown 3\nf 1 2 3";
    cr_assert(read_text(&arena, text, NULL, &m, &error), "%s", error.text);
    cr_assert_eq(m.face_count, 7);
    cr_assert_eq(m.skipped, 7, "%d lines skipped", m.skipped);
    cr_assert_eq(m.faces[1].corner_count, 4);
    cr_assert_eq(m.faces[4].corner_count, 4);
    for (int i = 0; i < 4; i++) cr_assert_eq(m.corners[m.faces[4].first_corner + i], i);
    cr_assert_str_eq(m.groups[m.faces[0].group], "");
    cr_assert_str_eq(m.groups[m.faces[1].group], "first door");
    cr_assert_str_eq(m.groups[m.faces[4].group], "second");
    cr_assert_str_eq(m.materials[m.faces[4].material].name, "red");
    // The box holds what faces use: vertex 5 is not a number, vertex 6 is used.
    cr_assert_eq(m.box.max.x, 7);
    cr_assert_eq(m.box.min.x, 0);
    arena_free(&arena);
}

static bool read_library(void *context, const char *name, Arena *arena, Bytes *out) {
    if (strcmp(name, "my colours.mtl") != 0) return false;
    *out = text_bytes(arena, context);
    return true;
}

// Libraries give colour and transparency; without one the name does (test_obj_materials.c).
Test(obj, reads_materials) {
    Arena arena = {0};
    ObjModel m;
    Error error;
    char library[] =
        "newmtl pane\nKd 0.5 1 0\nd 0.25\nnewmtl tr\nTr 0.75\nKd 2 -1 nan\nnewmtl wild\nd x\nKd\n";
    ObjFiles files = {.read = read_library, .context = library};
    const char *text =
        "mtllib my colours.mtl\nmtllib missing.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\n"
        "usemtl pane\nf 1 2 3\nusemtl tr\nf 1 2 3\nusemtl dkgrey\nf 1 2 3\nusemtl my glass\nf 1 2 3\n";
    cr_assert(read_text(&arena, text, &files, &m, &error), "%s", error.text);
    const ObjMaterial *pane = &m.materials[m.faces[0].material], *tr = &m.materials[m.faces[1].material];
    cr_assert(pane->known && tr->known && m.materials[m.faces[2].material].known);
    cr_assert_float_eq((double)pane->colour.r, (double)maps_linear(128), 1e-6);
    cr_assert_float_eq((double)pane->colour.g, (double)MAPS_MAX_COLOUR, 1e-6);
    cr_assert_float_eq((double)pane->alpha, 0.25, 1e-6);
    cr_assert_float_eq((double)tr->alpha, 0.25, 1e-6);
    cr_assert_lt(m.materials[m.faces[2].material].colour.r, maps_linear(128), "dkgrey is dark");
    cr_assert_lt(m.materials[m.faces[3].material].alpha, 1.0f);
    cr_assert_eq(m.skipped, 1, "the missing library is counted");
    cr_assert_not(read_text(&arena, "v 0 0 0\n", NULL, &m, &error));
    cr_assert(strstr(error.text, "no usable face"), "%s", error.text);
    cr_assert_not(read_text(&arena, "", NULL, &m, &error));
    arena_free(&arena);
}

// Any bytes at all are read without a crash: 2,000 texts of tokens in random order, cut anywhere.
Test(obj, survives_random_text) {
    static const char *const TOKENS[] = {"v ",           "f ", "g ",  "usemtl ",   "mtllib ", "1 ", "-1 ",
                                         "2/3 ",         "0 ", "3//", "1e9",       " nan ",   "\n", "\n",
                                         "\\\n",         "#",  "\r",  "v 1 2 3\n", "-2 ",     "/",  "f 1 2 3",
                                         "99999999999 ", "o",  "\t",  "\xff",      "d ",      "\n"};
    uint64_t seed = 7;
    Random random = {seed};
    for (int round = 0; round < 2000; round++) {
        Arena arena = {0};
        char text[600] = "";
        int count = random_index(&random, 60);
        for (int i = 0; i < count; i++)
            strcat(text, TOKENS[random_index(&random, sizeof TOKENS / sizeof *TOKENS)]);
        ObjModel m;
        Error error = {""};
        bool good = read_text(&arena, text, NULL, &m, &error);
        cr_assert(good || strlen(error.text) > 0, "seed %llu round %d", (unsigned long long)seed, round);
        for (int i = 0; good && i < m.corner_count; i++)
            cr_assert(m.corners[i] >= 0 && m.corners[i] < m.vertex_count, "seed %llu round %d",
                      (unsigned long long)seed, round);
        arena_free(&arena);
    }
}

static Bytes make_png(Arena *arena, int width, int height, const unsigned char *rgba) {
    png_image image = {.version = PNG_IMAGE_VERSION,
                       .width = (unsigned)width,
                       .height = (unsigned)height,
                       .format = PNG_FORMAT_RGBA};
    png_alloc_size_t size = 0;
    cr_assert(png_image_write_to_memory(&image, NULL, &size, 0, rgba, 0, NULL));
    Bytes out = {ARENA_ARRAY(arena, unsigned char, size + 1), size};
    cr_assert(png_image_write_to_memory(&image, out.data, &size, 0, rgba, 0, NULL));
    return out;
}

// The mean is taken in linear light and by opacity; damaged images are refused.
Test(texture, mean_of_a_chequer) {
    Arena arena = {0};
    const unsigned char pixels[] = {0, 0, 0, 255, 255, 128, 0, 255, 9, 9, 9, 0, 9, 9, 9, 0};
    Bytes png = make_png(&arena, 2, 2, pixels);
    Rgb mean;
    cr_assert(texture_mean(png, NULL, &mean));
    // Tolerance: single precision.
    cr_assert_float_eq((double)mean.r, (double)maps_linear(255) / 2, 1e-6);
    cr_assert_float_eq((double)mean.g, (double)maps_linear(128) / 2, 1e-6);
    cr_assert_float_eq((double)mean.b, 0, 1e-6);
    for (size_t cut = 0; cut < png.size - 12; cut++) {
        unsigned char copy[4096];
        memcpy(copy, png.data, cut);
        texture_mean((Bytes){copy, cut}, NULL, &mean);
    }
    cr_assert_not(texture_mean((Bytes){png.data, 20}, NULL, &mean));
    const unsigned char clear[4] = {1, 2, 3, 0};
    cr_assert_not(texture_mean(make_png(&arena, 1, 1, clear), NULL, &mean), "nothing opaque, no colour");
    arena_free(&arena);
}

// The most memory this process ever had, bytes, touched or not.
static long long peak_memory(void) {
    char line[200];
    long long kib = -1;
    FILE *status = fopen("/proc/self/status", "r");
    cr_assert_not_null(status);
    while (fgets(line, sizeof line, status))
        if (strncmp(line, "VmPeak:", 7) == 0) kib = atoll(line + 7);
    fclose(status);
    cr_assert(kib > 0);
    return kib << 10;
}

// Proves that pictures stop being decoded where they are more than their bytes are worth.
Test(texture, pixels_are_counted) {
    Arena arena = {0};
    unsigned char grey[4] = {128, 128, 128, 255};
    Bytes png = make_png(&arena, 1, 1, grey);
    double worth = (double)png.size * TEXTURE_PIXELS_A_BYTE, left = 1 - worth;
    Rgb mean;
    cr_assert(texture_mean(png, &left, &mean));
    cr_assert_eq(left, 0);
    left = 0.5 - worth;
    cr_assert_not(texture_mean(png, &left, &mean));
    cr_assert_eq(left, 0.5, "what was refused cost nothing");
    arena_free(&arena);
}

// Proves that a file of a few bytes does not make the decoder ask for gigabytes: a piece of this one calls itself 1.75 GiB
// long. Found by fuzz_sh3d. Limit: 512 MiB at once are granted, and something else may grow meanwhile.
Test(texture, claims_of_gigabytes_are_not_believed) {
    Arena arena = {0};
    Bytes seed = support_read(&arena, "tests/seeds/claims-gigabytes.sh3d-part");
    Bytes png = {seed.data + 1, seed.size - 1};
    Rgb mean;
    cr_assert_eq(texture_pixels(png), 6);
    long long before = peak_memory();
    cr_assert_not(texture_mean(png, NULL, &mean));
    cr_assert_lt(peak_memory() - before, 900LL << 20);
    arena_free(&arena);
}

typedef struct Beside {
    char *library;
    Bytes image, mask;
} Beside;

static bool read_beside(void *context, const char *name, Arena *arena, Bytes *out) {
    const Beside *beside = context;
    (void)arena;
    if (strcmp(name, "lib.mtl") == 0)
        *out = (Bytes){(unsigned char *)beside->library, strlen(beside->library)};
    if (strcmp(name, "a picture.png") == 0) *out = beside->image;
    if (strcmp(name, "mask.png") == 0) *out = beside->mask;
    if (strcmp(name, "broken.png") == 0) *out = (Bytes){beside->image.data, 40};
    return strcmp(name, "missing.png") != 0;
}

// Pictures of a library: options before a name with blanks, a mask in map_d, whatever the order of the lines; broken and missing pictures
// cost their colours and are counted. Texture coordinates by all ways to write a corner. Tolerance: a code of 255.
Test(obj, reads_pictures) {
    Arena arena = {0};
    Building b = {0};
    const unsigned char grey[] = {128, 128, 128, 255, 128, 128, 128, 255},
                        half[] = {255, 255, 255, 255, 0, 0, 0, 255};
    char library[] =
        "newmtl one\nmap_Kd -s 2 3 -clamp on -o 0.5 0.25 0 a picture.png\nKd 1 0 0\nd 0.5\n"
        "newmtl holes\nmap_d mask.png\nmap_Kd a picture.png\n"
        "newmtl cut\nmap_d mask.png\nKd 0 1 0\n"
        "newmtl lost\nKd 0 0 1\nmap_Kd missing.png\nnewmtl broken\nKd 0 0 1\nmap_Kd -o 1 broken.png\n";
    Beside beside = {library, make_png(&arena, 2, 1, grey), make_png(&arena, 2, 1, half)};
    ObjFiles files = {.read = read_beside, .context = &beside, .b = &b};
    ObjModel m;
    Error error;
    cr_assert(read_text(&arena,
                        "mtllib lib.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0 0\nvt 0 x\nusemtl one\n"
                        "f 1/1 2/2 3/3\nf 1/-3/1 2/-2/1 3/1\nf 1/1 2 3/3\nf 1/1 2/4 3/1\n",
                        &files, &m, &error),
              "%s", error.text);
    Vec2 at[3];
    cr_expect(obj_places(&m, &m.faces[0], at) && at[1].x == 1 && at[1].y == 0);
    cr_expect(obj_places(&m, &m.faces[1], at) && at[1].x == 1 && at[2].x == 0);
    cr_expect_not(obj_places(&m, &m.faces[2], at), "a corner has none");
    cr_expect_not(obj_places(&m, &m.faces[3], at), "a corner's is beyond");
    const ObjMaterial *one = &m.materials[1], *holes = one + 1, *cut = one + 2, *lost = one + 3,
                      *broken = one + 4;
    cr_expect(one->texture == 1 && one->alpha == 0.5f);
    cr_expect(one->scale.x == 2 && one->scale.y == 3 && one->offset.x == 0.5 && one->offset.y == 0.25);
    cr_expect_float_eq((double)one->colour.r, (double)maps_linear(128), 1e-6);
    cr_expect_eq(b.textures[holes->texture].opacity, 0.5f, "half of it is a hole");
    cr_expect_eq(b.textures[cut->texture].opacity, 0.5f);
    cr_expect_float_eq((double)cut->colour.g, (double)MAPS_MAX_COLOUR, 0.01);
    cr_expect_eq(lost->texture + broken->texture, 0);
    cr_expect_float_eq((double)lost->colour.b, (double)MAPS_MAX_COLOUR, 1e-6);
    cr_expect_eq(m.skipped, 2);
    arena_free(&arena);
}
