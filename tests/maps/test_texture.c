// test_texture.c - pictures kept, read and laid on polygons.
#include <criterion/criterion.h>
#include <string.h>

#include "engine/core/random.h"
#include "maps/building/texture.h"

// Proves that each smaller level has the mean of the picture, sides that are not powers of two included, and that a transparent
// texel's colour counts nowhere. Tolerance: half a code of 255 in each level, near linear light 0.5 where a code is 0.0058.
Test(texture, levels_keep_the_mean) {
    Arena arena = {0};
    Building b = {0};
    enum { WIDTH = 37, HEIGHT = 22 };
    uint8_t pixels[HEIGHT * WIDTH * 4];
    Random random = {5};
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        bool clear = random_index(&random, 4) == 0;
        for (int c = 0; c < 3; c++)
            pixels[4 * i + c] = (uint8_t)(clear ? 255 : 150 + random_index(&random, 60));
        pixels[4 * i + 3] = clear ? 0 : 255;
    }
    int t = texture_add_pixels(&arena, &b, "noise", WIDTH, HEIGHT, pixels);
    cr_assert_eq(t, 1, "entry 0 is no texture");
    const Texture *texture = &b.textures[t];
    for (int level = 0; level < 7; level++) {
        int width, height;
        const uint8_t *texels = texture_level(texture, level, &width, &height);
        double sum = 0, weight = 0;
        for (int i = 0; i < width * height; i++) {
            sum += (double)maps_linear(texels[4 * i]) * texels[4 * i + 3];
            weight += texels[4 * i + 3];
        }
        cr_expect_float_eq(sum / weight, (double)texture->mean.r, 0.0058 * (0.5 * level + 0.01), "level %d",
                           level);
        cr_expect_float_eq(weight / 255 / (width * height), (double)texture->opacity, 0.002 * (level + 1));
    }
    int width, height;
    texture_level(texture, 30, &width, &height);
    cr_expect(width == 1 && height == 1);
    arena_free(&arena);
}

// Proves that the texels of a picture are read at their middles, from the top left, that the picture repeats, and that halfway between
// two texels it is their mean in linear light.
Test(texture, reads_texels_where_they_lie) {
    Arena arena = {0};
    Building b = {0};
    const uint8_t pixels[] = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 0, 0, 0, 255};
    int added = texture_add_pixels(&arena, &b, "four", 2, 2, pixels);
    const Texture *t = &b.textures[added];
    // Tolerance: single precision.
    for (int turn = -2; turn <= 2; turn++) {
        Texel left = texture_read(t, turn + 0.25, turn + 0.25, 1),
              right = texture_read(t, turn + 0.75, 0.25, 1), below = texture_read(t, 0.25, turn + 0.75, 1),
              half = texture_read(t, turn + 0.5, 0.25, 1);
        cr_expect_float_eq((double)left.colour.r, (double)MAPS_MAX_COLOUR, 1e-6);
        cr_expect_float_eq((double)left.colour.g, 0, 1e-6);
        cr_expect_float_eq((double)right.colour.g, (double)MAPS_MAX_COLOUR, 1e-6);
        cr_expect_float_eq((double)below.colour.b, (double)MAPS_MAX_COLOUR, 1e-6);
        cr_expect_float_eq((double)half.colour.r, (double)MAPS_MAX_COLOUR / 2, 1e-6);
        cr_expect_float_eq((double)half.opacity, 1, 1e-6);
    }
    arena_free(&arena);
}

// Proves that large pictures are halved to TEXTURE_SIDE, and that however many there are, all together stay within
// TEXTURE_MOST_TEXELS and none is refused.
Test(texture, many_large_pictures_stay_within_bounds) {
    enum { SIDE = 1500, COUNT = 60 };
    Arena arena = {0}, scratch = {0};
    Building b = {0};
    uint8_t *pixels = ARENA_ARRAY(&scratch, uint8_t, SIDE * SIDE * 4);
    memset(pixels, 200, SIDE * SIDE * 4);
    double kept = 0;
    for (int i = 0; i < COUNT; i++) {
        int t = texture_add_pixels(&arena, &b, "large", SIDE, SIDE, pixels);
        cr_assert_eq(t, i + 1);
        kept += (double)b.textures[t].width * b.textures[t].height;
        cr_assert_leq(b.textures[t].width, TEXTURE_SIDE);
    }
    cr_expect_eq(b.textures[1].width, SIDE / 2);
    cr_expect_lt(b.textures[COUNT].width, SIDE / 2);
    cr_expect_leq(kept, TEXTURE_MOST_TEXELS);
    arena_free(&arena);
    arena_free(&scratch);
}

static Vec2 place_of(const Building *b, int polygon, int corner) {
    const Polygon *p = &b->polygons[polygon];
    const TextureMap *t = &b->texture_maps[p->texture_map];
    Vec3 v = b->vertices[p->first_vertex + corner];
    return vec2(vec3_dot(t->u, v) + t->u0, vec3_dot(t->v, v) + t->v0);
}

// Proves that each corner of a polygon has the place in the picture that was given for it, whole polygons with one map and those that
// are cut since no map fits alike, and that polygons without places or without a picture have no map. Slanted quads are random.
Test(texture, corners_have_their_places) {
    Arena arena = {0};
    Building b = {0};
    const uint8_t grey[] = {128, 128, 128, 255};
    int texture = texture_add_pixels(&arena, &b, "grey", 1, 1, grey);
    int plain = building_add_material(&arena, &b, (Material){.name = "plain", .alpha = 1});
    int papered =
        building_add_material(&arena, &b, (Material){.name = "papered", .alpha = 1, .texture = texture});
    building_add_object(&arena, &b, OBJECT_FURNITURE, "thing");
    Random random = {7};
    for (int round = 0; round < 200; round++) {
        Vec3 x = vec3_normalize(vec3(random_between(&random, -1, 1), random_between(&random, -1, 1), 0.3));
        Vec3 y = vec3_normalize(vec3_cross(x, vec3(0.2, 0.1, 1)));
        Vec3 at = vec3(random_between(&random, -100, 100), 5, 2);
        bool even = round % 2 == 0;
        Vec3 v[4];
        Vec2 place[4];
        static const double CORNER[4][2] = {{0, 0}, {2, 0}, {2, 1}, {0, 1}};
        for (int i = 0; i < 4; i++) {
            v[i] = vec3_add(at, vec3_add(vec3_scale(x, CORNER[i][0]), vec3_scale(y, CORNER[i][1])));
            place[i] = vec2(3 * CORNER[i][0] + CORNER[i][1] - 4, (even || i != 2 ? 2 : 9) * CORNER[i][1]);
        }
        int first = b.polygon_count, added = building_add_textured(&arena, &b, v, place, 4, papered);
        cr_assert_eq(added, even ? 1 : 2);
        for (int p = first; p < b.polygon_count; p++) {
            for (int k = 0; k < b.polygons[p].vertex_count; k++) {
                Vec2 is = place_of(&b, p, k);
                bool found = false;
                // Tolerance: coordinates of 100 m, maps of 9 / m, doubles.
                for (int i = 0; i < 4; i++)
                    if (vec3_equal(v[i], b.vertices[b.polygons[p].first_vertex + k]))
                        found = vec2_length(vec2_sub(is, place[i])) < 1e-11;
                cr_expect(found, "round %d", round);
            }
        }
        cr_assert_eq(building_add_textured(&arena, &b, v, place, 4, plain), 1);
        cr_expect_eq(b.polygons[b.polygon_count - 1].texture_map, 0);
        cr_assert_eq(building_add_textured(&arena, &b, v, NULL, 4, papered), 1);
        cr_expect_eq(b.polygons[b.polygon_count - 1].texture_map, 0);
    }
    arena_free(&arena);
}

// Proves that a material's reflectance at a point follows its picture in proportion to the mean, and that from far it is the mean.
// Tolerance: a code of the smallest level.
Test(texture, material_follows_its_picture) {
    Arena arena = {0};
    Building b = {0};
    const uint8_t pixels[] = {200, 200, 200, 255, 100, 100, 100, 255};
    int texture = texture_add_pixels(&arena, &b, "stripes", 2, 1, pixels);
    int map = building_add_texture_map(&arena, &b, (TextureMap){{0.5, 0, 0}, {0, 0, 0.5}, 0, 0});
    Rgb mean = b.textures[texture].mean, half = {mean.r / 2, mean.g / 2, mean.b / 2};
    int m = building_add_material(
        &arena, &b,
        (Material){
            .name = "dimmed", .reflectance = half, .alpha = 1, .texture = texture, .texture_map = map});
    Texel light = texture_at(&b, m, 0, vec3(0.5, 3, 1), 0), dark = texture_at(&b, m, 0, vec3(1.5, 3, 1), 0),
          far = texture_at(&b, m, 0, vec3(1.5, 3, 1), 100);
    cr_expect_float_eq((double)light.colour.r, (double)maps_linear(200) / 2, 1e-6);
    cr_expect_float_eq((double)dark.colour.r, (double)maps_linear(100) / 2, 1e-6);
    cr_expect_float_eq((double)far.colour.r, (double)half.r, 0.003);
    arena_free(&arena);
}
