// test_obj_materials.c - materials that a model calls by name, by Sweet Home 3D's table and by libraries.
#include <criterion/criterion.h>
#include <stdio.h>
#include <string.h>

#include "maps/polygons/obj.h"
#include "tests/support/support.h"

static ObjModel read_text(Arena *arena, const char *text, const ObjFiles *files) {
    ObjModel m;
    Error error;
    Bytes bytes = {(unsigned char *)arena_string(arena, text), strlen(text)};
    cr_assert(obj_read(bytes, "model", files, arena, &m, &error), "%s", error.text);
    return m;
}

static bool read_library(void *context, const char *name, Arena *arena, Bytes *out) {
    (void)name;
    *out = (Bytes){(unsigned char *)arena_string(arena, context), strlen(context)};
    return true;
}

// The table is complete: its size, its order (on which the search relies), and the sums of its columns as they are in
// the constants of Sweet Home 3D's loader, in ten-thousandths of Kd and hundredths of d and of Ns. Some rows are
// compared one by one.
Test(obj_materials, table_is_that_of_sweet_home_3d) {
    static const ObjNamed SPOTS[] = {{"amber", {0.5755, 0.2678, 0}, 1, 60},
                                     {"flbrown", {0.1102, 0.0120, 0.0013}, 1, 0},
                                     {"bone2", {0.9837, 0.8620, 0.6504}, 1, 0},
                                     {"redwood", {0.2571, 0.0330, 0}, 1, 91.47},
                                     {"brzskin", {0.3796, 0.2898, 0.2122}, 1, 25},
                                     {"iris", {0, 0.0572, 0.3184}, 1, 128},
                                     {"smoked_glass", {0.0041, 0.0041, 0.0041}, 0.02, 91.47},
                                     {"offwhite.warm", {0.8367, 0.6898, 0.4490}, 1, 60},
                                     {"default", {0.7102, 0.7020, 0.6531}, 1, 128},
                                     {"fldkpurple", {0.1612, 0, 0.3347}, 1, 0},
                                     {"glass", {0.4873, 0.4919, 0.5306}, 1, 128}};
    for (size_t i = 0; i < sizeof SPOTS / sizeof *SPOTS; i++) {
        const ObjNamed *found = obj_named(SPOTS[i].name), *spot = &SPOTS[i];
        cr_assert_not_null(found, "%s", spot->name);
        for (int c = 0; c < 3; c++) cr_expect_eq(found->diffuse[c], spot->diffuse[c], "%s", spot->name);
        cr_expect(found->alpha == spot->alpha && found->exponent == spot->exponent, "%s", spot->name);
    }
    cr_expect_null(obj_named("Amber"));
    cr_expect_null(obj_named("amber "));
    cr_expect_null(obj_named(""));
    long sum[5] = {0};
    for (int i = 0; i < OBJ_NAMED_COUNT; i++) {
        const ObjNamed *n = &OBJ_NAMED[i];
        cr_assert(i == 0 || strcmp(OBJ_NAMED[i - 1].name, n->name) < 0, "%s", n->name);
        for (int c = 0; c < 3; c++) sum[c] += lrint(10000 * n->diffuse[c]);
        sum[3] += lrint(100 * n->alpha);
        sum[4] += lrint(100 * n->exponent);
    }
    cr_expect_eq(sum[0], 524230);
    cr_expect_eq(sum[1], 406822);
    cr_expect_eq(sum[2], 321757);
    cr_expect_eq(sum[3], 12430);
    cr_expect_eq(sum[4], 738535);
}

// A model without a library has the colours of the table: as codes of a screen within one step, which is the
// rounding, and none above white paint.
Test(obj_materials, every_name_gives_its_colour) {
    Arena arena = {0};
    char text[OBJ_NAMED_COUNT * 64] = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (int i = 0; i < OBJ_NAMED_COUNT; i++) {
        size_t used = strlen(text);
        snprintf(text + used, sizeof text - used, "usemtl  %s \nf 1 2 3\n", OBJ_NAMED[i].name);
    }
    ObjModel m = read_text(&arena, text, NULL);
    cr_assert_eq(m.face_count, OBJ_NAMED_COUNT);
    for (int i = 0; i < OBJ_NAMED_COUNT; i++) {
        const ObjMaterial *got = &m.materials[m.faces[i].material];
        const float channel[3] = {got->colour.r, got->colour.g, got->colour.b};
        cr_assert(got->known, "%s", OBJ_NAMED[i].name);
        for (int c = 0; c < 3; c++) {
            double code = 255 * OBJ_NAMED[i].diffuse[c];
            cr_expect(channel[c] >= maps_linear((int)floor(code)) &&
                          channel[c] <= maps_linear((int)ceil(code)),
                      "%s, channel %d: %g", got->name, c, (double)channel[c]);
        }
        cr_expect_float_eq((double)got->alpha, OBJ_NAMED[i].alpha, 1e-6);
        cr_expect_float_eq((double)got->shininess, OBJ_NAMED[i].exponent / 128, 1e-6);
    }
    arena_free(&arena);
}

// A name that nobody knows, and one in other letters, has the colour of `default`; faces before the first name have
// it too, but there no name is missing. All are matt. Unknown glass is seen through.
Test(obj_materials, unknown_names_have_the_default) {
    Arena arena = {0};
    ObjModel m =
        read_text(&arena,
                  "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl wood7\nf 1 2 3\nusemtl White\nf 1 2 3\n"
                  "usemtl Window Glass\nf 1 2 3\n",
                  NULL);
    for (int i = 0; i < 4; i++) {
        const ObjMaterial *got = &m.materials[m.faces[i].material];
        cr_expect_eq(got->known, i == 0, "face %d", i);
        cr_expect_eq(got->colour.r, maps_linear(181));  // 0.7102
        cr_expect_eq(got->colour.g, maps_linear(179));  // 0.7020
        cr_expect_eq(got->colour.b, maps_linear(167));  // 0.6531
        cr_expect_eq(got->alpha < 1, i == 3, "face %d", i);
        cr_expect_eq(got->shininess, 0, "face %d", i);
    }
    arena_free(&arena);
}

// Shininess of libraries: a share of 128 and no more; none where the illumination model or a black Ks says that there are no highlights,
// in whatever order. A mirror only where the model reflects rays, and sharply. A library's material has nothing of the table's of that
// name.
Test(obj_materials, shininess_of_libraries) {
    static const struct {
        const char *lines;
        double shininess, mirror;
    } CASES[] = {{"Ns 64\nillum 2\nKs 0.3 0.3 0.3\n", 0.5, 0},
                 {"Ns 1000\n", 1, 0},
                 {"Ns -5\n", 0, 0},
                 {"Ns nan\n", 0, 0},
                 {"Ns 64\nillum 1\n", 0, 0},
                 {"illum 0\nNs 64\n", 0, 0},
                 {"Ks 0 0 0\nNs 64\n", 0, 0},
                 {"Ns 64\nKs 0\n", 0, 0},
                 {"Ks 0 0 0.1\nNs 32\n", 0.25, 0},
                 {"Ks 0.9 0.8 0.7\nillum 3\nNs 900\n", 1, 0.8},
                 {"Ns 500\nillum 5\nKs 0.5\n", 1, 0.5},
                 {"Ks 0.9 0.8 0.7\nillum 2\nNs 900\n", 1, 0},
                 {"Ks 0.9 0.8 0.7\nillum 3\nNs 100\n", 100 / 128.0, 0},
                 {"", 0, 0}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Arena arena = {0};
        char library[200];
        snprintf(library, sizeof library, "newmtl other\nillum 0\nKs 0 0 0\nnewmtl amber\n%s",
                 CASES[i].lines);
        ObjFiles files = {.read = read_library, .context = library};
        ObjModel m =
            read_text(&arena, "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl amber\nf 1 2 3\n", &files);
        const ObjMaterial *got = &m.materials[m.faces[0].material];
        cr_expect_float_eq((double)got->shininess, CASES[i].shininess, 1e-6, "case %zu", i);
        cr_expect_float_eq((double)got->mirror, CASES[i].mirror, 1e-6, "case %zu", i);
        cr_expect(got->known && got->colour.b == MAPS_MAX_COLOUR, "case %zu: white, not amber", i);
        arena_free(&arena);
    }
}
