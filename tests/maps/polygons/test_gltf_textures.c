// test_gltf_textures.c - how pictures lie on the polygons of a glTF file.
#include <criterion/criterion.h>
#include <string.h>
#include <webp/encode.h>

#include "tests/support/files/gltf_fixture.h"
#include "tests/support/support.h"

// A floor of 4 m x 2 m of two triangles, y up, with two sets of places in pictures.
enum { FLOOR_BYTES = 48 + 32 + 32 + 12 };
static GltfDocument floor_document(Arena *arena, const char *texture, const char *images) {
    static const float POSITION[12] = {0, 0, 0, 4, 0, 0, 4, 0, -2, 0, 0, -2},
                       PLACE[2][8] = {{0, 1, 1, 1, 1, 0, 0, 0}, {0, 2, 3, 2, 3, 0, 0, 0}};
    static const uint16_t INDEX[6] = {0, 1, 2, 0, 2, 3};
    unsigned char bytes[FLOOR_BYTES];
    memcpy(bytes, POSITION, 48), memcpy(bytes + 48, PLACE, 64), memcpy(bytes + 112, INDEX, 12);
    GltfDocument d = gltf_usual();
    d.head = arena_format(arena,
                          "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0%s}}}],"
                          "\"samplers\":[{\"wrapS\":33071}],%s,",
                          texture, images);
    d.mesh =
        "{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1,\"TEXCOORD_1\":2},\"indices\":3,"
        "\"material\":0}]}";
    d.accessors = "[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
                  "{\"bufferView\":1,\"componentType\":5126,\"count\":4,\"type\":\"VEC2\"},"
                  "{\"bufferView\":2,\"componentType\":5126,\"count\":4,\"type\":\"VEC2\"},"
                  "{\"bufferView\":3,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}]";
    d.views = "[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,\"byteLength\":32},"
              "{\"buffer\":0,\"byteOffset\":80,\"byteLength\":32},{\"buffer\":0,\"byteOffset\":112,"
              "\"byteLength\":12}]";
    d.buffer = arena_format(arena, "{\"byteLength\":124,\"uri\":\"data:;base64,%s\"}",
                            gltf_base64(arena, bytes, FLOOR_BYTES));
    return d;
}

static const char *four_texels(Arena *arena) {
    static const uint8_t PIXELS[16] = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 9, 9, 9, 255};
    Bytes png = support_png(arena, 2, 2, PIXELS);
    return gltf_base64(arena, png.data, png.size);
}

// Proves that the floor is one polygon whose corners have the places that the file gives, by hand: set 0 and set 1, scaled, shifted
// and turned counter-clockwise as the picture is seen (v is down, so a quarter turn takes (u, v) to (v, -u)).
Test(gltf_textures, corners_have_their_places) {
    static const struct {
        const char *texture;
        Vec2 near_left, far_right;  // of the corners at (0, 0) and (4, 2)
        Vec2 near_right;            // at (4, 0)
    } CASES[] = {
        {"", {0, 1}, {1, 0}, {1, 1}},
        {",\"texCoord\":1", {0, 2}, {3, 0}, {3, 2}},
        {",\"extensions\":{\"KHR_texture_transform\":{\"texCoord\":1,\"scale\":[2,0.5]}}",
         {0, 1},
         {6, 0},
         {6, 1}},
        {",\"extensions\":{\"KHR_texture_transform\":{\"offset\":[0.25,-3],\"scale\":[2,4]}}",
         {0.25, 1},
         {2.25, -3},
         {2.25, 1}},
        {",\"extensions\":{\"KHR_texture_transform\":{\"offset\":[10,20],\"scale\":[2,4],"
         "\"rotation\":1.5707963267948966}}",
         {14, 20},
         {10, 18},
         {14, 18}},
    };
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Arena arena = {0};
        Building b;
        GltfDocument d = floor_document(
            &arena, CASES[i].texture,
            arena_format(&arena, "\"textures\":[{\"source\":0}],\"images\":[{\"uri\":\"data:;base64,%s\"}]",
                         four_texels(&arena)));
        gltf_accept(&arena, &d, &b);
        cr_assert_eq(b.polygon_count, 1, "both triangles are one");
        cr_assert_eq(b.texture_count, 2);
        cr_assert_eq(b.materials[b.polygons[0].material].texture, 1);
        const TextureMap *map = &b.texture_maps[b.polygons[0].texture_map];
        const struct {
            Vec3 at;
            Vec2 place;
        } CORNERS[] = {{{0, 0, 0}, CASES[i].near_left},
                       {{4, 2, 0}, CASES[i].far_right},
                       {{4, 0, 0}, CASES[i].near_right}};
        // Tolerance: doubles, of places up to 20.
        for (int k = 0; k < 3; k++) {
            cr_expect_float_eq(vec3_dot(map->u, CORNERS[k].at) + map->u0, CORNERS[k].place.x, 1e-12, "%d, %d",
                               (int)i, k);
            cr_expect_float_eq(vec3_dot(map->v, CORNERS[k].at) + map->v0, CORNERS[k].place.y, 1e-12, "%d, %d",
                               (int)i, k);
        }
        arena_free(&arena);
    }
}

// Proves that a sampler that clamps is noted where, and only where, a corner lies beyond the picture, and that a set of places which is
// not there costs the picture's places, one note and no more.
Test(gltf_textures, ends_and_missing_places) {
    static const struct {
        const char *texture;
        int repeated, placeless;
    } CASES[] = {{"", 0, 0}, {",\"texCoord\":1", 1, 0}, {",\"texCoord\":2", 0, 1}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Arena arena = {0};
        Building b;
        GltfDocument d = floor_document(
            &arena, CASES[i].texture,
            arena_format(
                &arena,
                "\"textures\":[{\"source\":0,\"sampler\":0}],\"images\":[{\"uri\":\"data:;base64,%s\"}]",
                four_texels(&arena)));
        gltf_accept(&arena, &d, &b);
        cr_expect_eq(soups_notes(&b, "1 primitives reach beyond their texture"), CASES[i].repeated);
        cr_expect_eq(soups_notes(&b, "do not say how it lies"), CASES[i].placeless);
        cr_expect_eq(b.polygons[0].texture_map > 0, !CASES[i].placeless);
        cr_expect_eq(b.polygon_count, 1);
        arena_free(&arena);
    }
}

// Proves that a WebP picture named by EXT_texture_webp is read, and that one cut short costs a note and no more. Lossless, so exact.
Test(gltf_textures, webp) {
    Arena arena = {0};
    static const uint8_t PIXELS[8] = {200, 100, 50, 255, 10, 20, 30, 255};
    uint8_t *webp = NULL;
    size_t size = WebPEncodeLosslessRGBA(PIXELS, 2, 1, 8, &webp);
    cr_assert_gt(size, 0);
    for (int cut = 0; cut < 2; cut++) {
        Building b;
        const char *picture = gltf_base64(&arena, webp, cut ? size - 6 : size);
        GltfDocument d = floor_document(
            &arena, "",
            arena_format(&arena,
                         "\"textures\":[{\"extensions\":{\"EXT_texture_webp\":{\"source\":0}}}],"
                         "\"images\":[{\"uri\":\"data:;base64,%s\"}]",
                         picture));
        gltf_accept(&arena, &d, &b);
        cr_expect_eq(soups_notes(&b, "1 textures are missing or could not be decoded"), cut);
        if (cut) continue;
        cr_assert_eq(b.texture_count, 2);
        cr_expect_arr_eq(b.textures[1].texels, PIXELS, sizeof PIXELS);
    }
    WebPFree(webp);
    arena_free(&arena);
}
