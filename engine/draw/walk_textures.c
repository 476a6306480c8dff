// walk_textures.c - pictures as arrays of textures. A texel is kept as the square root of its share of the picture's brightest texel, in
// each channel: 8 bits then suffice in the dark, and a square costs a shader less than decoding sRGB. Smaller levels are means in linear
// light (Williams 1983), weighted by opacity; a transparent texel takes the colour of the level above it, which bleeds in at edges.
#include "engine/draw/walk_textures.h"

#include <glad/gl.h>
#include <stdio.h>
#include <string.h>

#include "engine/draw/walk_mesh.h"
#include "engine/gl/gl_context.h"
#include "maps/building/texture.h"

// Pictures with sides up to this are in the first array, larger ones in the second.
enum { SMALL_SIDE = 256, ARRAYS = WALK_RUNS - 1 };
// EXT_texture_filter_anisotropic, part of OpenGL since 4.6. A floor seen along is as sharp across as along.
enum { MAX_ANISOTROPY = 0x84FE, MOST_ANISOTROPY = 0x84FF };
static const float ANISOTROPY = 8;
static const float LUMINANCE[3] = {0.2126f, 0.7152f, 0.0722f};

// Where a picture is, and the strength of its texels (WalkPicture).
typedef struct Place {
    int run, layer;
    float strength[4];
} Place;

typedef struct Sides {
    int width, height, layers;
} Sides;

struct WalkTextures {
    const Building *building;
    Place *place;  // [texture_count]
    unsigned array[ARRAYS], sky;
    float sky_strength[3];
};

// ---- layers

// Four floats a texel: colour times opacity in linear light, and opacity; all levels, the finest first.
typedef struct Linear {
    float c[4];
} Linear;

static size_t texels_of(int width, int height) {
    size_t sum = (size_t)width * (size_t)height;
    while (width > 1 || height > 1) {
        width = width > 1 ? width / 2 : 1, height = height > 1 ? height / 2 : 1;
        sum += (size_t)width * (size_t)height;
    }
    return sum;
}

static void fill_finest(const Texture *texture, int width, int height, Linear *out) {
    double texels = fmax((double)texture->width / width, (double)texture->height / height);
    bool same = texture->width == width && texture->height == height;
#pragma omp parallel for schedule(static)
    for (int j = 0; j < height; j++) {
        for (int i = 0; i < width; i++) {
            size_t at = (size_t)j * (size_t)width + (size_t)i;
            Texel t;
            if (same) {
                const uint8_t *from = texture->texels + 4 * at;
                t = (Texel){{maps_linear(from[0]), maps_linear(from[1]), maps_linear(from[2])},
                            (float)from[3] / 255};
            } else {
                t = texture_read(texture, (i + 0.5) / width, (j + 0.5) / height, texels);
            }
            out[at] =
                (Linear){{t.colour.r * t.opacity, t.colour.g * t.opacity, t.colour.b * t.opacity, t.opacity}};
        }
    }
}

// Both sides are powers of two.
static void fill_coarser(const Linear *from, int fw, int fh, Linear *out) {
    int w = fw > 1 ? fw / 2 : 1, h = fh > 1 ? fh / 2 : 1, right = fw > 1, down = fh > 1;
    for (int j = 0; j < h; j++) {
        for (int i = 0; i < w; i++) {
            const Linear *a = from + (j << down) * fw + (i << right), *b = a + right, *c = a + down * fw,
                         *d = c + right;
            for (int k = 0; k < 4; k++) out[j * w + i].c[k] = 0.25f * (a->c[k] + b->c[k] + c->c[k] + d->c[k]);
        }
    }
}

// Divides the colours by their opacity; `coarser` is the next level, done already, or NULL.
static void fill_clear(Linear *level, int w, int h, const Linear *coarser) {
    int cw = w > 1 ? w / 2 : 1, right = w > 1, down = h > 1;
    for (int j = 0; j < h; j++) {
        for (int i = 0; i < w; i++) {
            float *t = level[j * w + i].c;
            const float *other = coarser ? coarser[(j >> down) * cw + (i >> right)].c : NULL;
            for (int k = 0; k < 3; k++) t[k] = t[3] > 0 ? t[k] / t[3] : other ? other[k] : 0;
        }
    }
}

// Fills `bytes` [texels_of * 4] with all levels of a picture of these sides; the strength is that of WalkPicture.
static void fill_layer(const Texture *texture, int width, int height, uint8_t *bytes, float strength[4]) {
    enum { MOST_LEVELS = 16 };
    size_t count = texels_of(width, height), at[MOST_LEVELS] = {0};
    int w[MOST_LEVELS] = {width}, h[MOST_LEVELS] = {height}, levels = 1;
    Arena scratch = {0};
    Linear *linear = arena_alloc(&scratch, count, sizeof *linear);
    fill_finest(texture, width, height, linear);
    for (; w[levels - 1] > 1 || h[levels - 1] > 1; levels++) {
        int l = levels - 1;
        w[levels] = w[l] > 1 ? w[l] / 2 : 1, h[levels] = h[l] > 1 ? h[l] / 2 : 1;
        at[levels] = at[l] + (size_t)w[l] * (size_t)h[l];
        fill_coarser(linear + at[l], w[l], h[l], linear + at[levels]);
    }
    for (int l = levels - 1; l >= 0; l--)
        fill_clear(linear + at[l], w[l], h[l], l + 1 < levels ? linear + at[l + 1] : NULL);
    float most[3] = {0, 0, 0}, factor[3];
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) most[k] = fmaxf(most[k], linear[i].c[k]);
    const float mean[3] = {texture->mean.r, texture->mean.g, texture->mean.b};
    for (int k = 0; k < 3; k++) {
        // A channel that is black throughout shows the material's reflectance.
        bool black = !(mean[k] > 0 && most[k] > 0);
        factor[k] = black ? 0 : 1 / most[k];
        strength[k] = black ? 1 : most[k] / mean[k];
    }
    strength[3] = texture->opacity > 0 ? 1 / texture->opacity : 1;
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++)
            bytes[4 * i + (size_t)k] =
                factor[k] > 0 ? (uint8_t)(sqrtf(linear[i].c[k] * factor[k]) * 255 + 0.5f) : 255;
        bytes[4 * i + 3] = (uint8_t)(linear[i].c[3] * 255 + 0.5f);
    }
    arena_free(&scratch);
}

// ---- upload

// The smallest power of two that is at least `side`.
static int power_of_two(int side) {
    int power = 1;
    while (power < side) power *= 2;
    return power;
}

static bool shown(const Building *b, int texture) {
    for (int m = 0; m < b->material_count; m++)
        if (b->materials[m].texture == texture) return true;
    return false;
}

// Chooses the array and layer of each picture, and the sides of the arrays' layers: as the largest picture's, halved while all of
// them together are too many texels.
static void lay_out(WalkTextures *t, int max_side, int max_layers, Sides sides[ARRAYS]) {
    const Building *b = t->building;
    for (int i = 1; i < b->texture_count; i++) {
        const Texture *picture = &b->textures[i];
        if (!shown(b, i)) continue;
        int a = picture->width > SMALL_SIDE || picture->height > SMALL_SIDE;
        if (sides[a].layers == max_layers) a = 1 - a;
        if (sides[a].layers == max_layers) continue;
        t->place[i].run = a + 1;
        t->place[i].layer = sides[a].layers++;
        sides[a].width = (int)fmax(sides[a].width, power_of_two(picture->width));
        sides[a].height = (int)fmax(sides[a].height, power_of_two(picture->height));
    }
    for (;;) {
        double texels[ARRAYS];
        for (int a = 0; a < ARRAYS; a++) {
            while (sides[a].width > max_side) sides[a].width /= 2;
            while (sides[a].height > max_side) sides[a].height /= 2;
            texels[a] = (double)sides[a].width * sides[a].height * sides[a].layers;
        }
        if (texels[0] + texels[1] <= WALK_TEXTURES_MOST_TEXELS) return;
        Sides *large = &sides[texels[1] > texels[0]];
        if (large->width > 1) large->width /= 2;
        if (large->height > 1) large->height /= 2;
    }
}

// In software the mean of two levels takes twice as long as the nearer one, and each sample of anisotropy as long as the whole triangle
// did without a picture: there pictures do without both.
static void set_filters(unsigned target, bool levels) {
    bool software = gl_is_software();
    int smaller = software ? GL_LINEAR_MIPMAP_NEAREST : GL_LINEAR_MIPMAP_LINEAR;
    glTexParameteri(target, GL_TEXTURE_MIN_FILTER, levels ? smaller : GL_LINEAR);
    glTexParameteri(target, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(target, GL_TEXTURE_WRAP_S, GL_REPEAT);
    glTexParameteri(target, GL_TEXTURE_WRAP_T, levels ? GL_REPEAT : GL_CLAMP_TO_EDGE);
    float most = 1;
    if (!levels || software) return;
    glGetFloatv(MOST_ANISOTROPY, &most);
    if (glGetError() == GL_NO_ERROR && most > 1)
        glTexParameterf(target, MAX_ANISOTROPY, fminf(most, ANISOTROPY));
}

static void upload_array(WalkTextures *t, int array, const Sides *sides) {
    const Building *b = t->building;
    if (sides->layers == 0) return;
    Arena scratch = {0};
    uint8_t *bytes = arena_alloc(&scratch, texels_of(sides->width, sides->height), 4);
    glGenTextures(1, &t->array[array]);
    walk_textures_bind(t, array + 1);
    set_filters(GL_TEXTURE_2D_ARRAY, true);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    for (int l = 0, w = sides->width, h = sides->height;; l++) {
        glTexImage3D(GL_TEXTURE_2D_ARRAY, l, GL_RGBA8, w, h, sides->layers, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                     NULL);
        if (w == 1 && h == 1) break;
        w = w > 1 ? w / 2 : 1, h = h > 1 ? h / 2 : 1;
    }
    for (int i = 1; i < b->texture_count; i++) {
        if (t->place[i].run != array + 1) continue;
        fill_layer(&b->textures[i], sides->width, sides->height, bytes, t->place[i].strength);
        const uint8_t *level = bytes;
        for (int l = 0, w = sides->width, h = sides->height;; l++) {
            glTexSubImage3D(GL_TEXTURE_2D_ARRAY, l, 0, 0, t->place[i].layer, w, h, 1, GL_RGBA,
                            GL_UNSIGNED_BYTE, level);
            if (w == 1 && h == 1) break;
            level += 4 * (size_t)w * (size_t)h;
            w = w > 1 ? w / 2 : 1, h = h > 1 ? h / 2 : 1;
        }
    }
    arena_free(&scratch);
}

static void upload_sky(WalkTextures *t, int max_side) {
    const Building *b = t->building;
    if (b->sky_texture <= 0) return;
    const Texture *picture = &b->textures[b->sky_texture];
    int width = (int)fmin(power_of_two(picture->width), max_side),
        height = (int)fmin(power_of_two(picture->height), max_side);
    float strength[4], luminance = 0;
    const float mean[3] = {picture->mean.r, picture->mean.g, picture->mean.b};
    for (int k = 0; k < 3; k++) luminance += LUMINANCE[k] * mean[k];
    if (!(luminance > 0)) return;
    Arena scratch = {0};
    uint8_t *bytes = arena_alloc(&scratch, texels_of(width, height), 4);
    fill_layer(picture, width, height, bytes, strength);
    for (int k = 0; k < 3; k++) t->sky_strength[k] = strength[k] * mean[k] / luminance;
    glGenTextures(1, &t->sky);
    glActiveTexture(GL_TEXTURE0 + WALK_UNIT_PICTURES);
    glBindTexture(GL_TEXTURE_2D, t->sky);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, bytes);
    set_filters(GL_TEXTURE_2D, false);
    arena_free(&scratch);
}

WalkTextures *walk_textures_new(const Building *building, Arena *arena, Error *error) {
    WalkTextures *t = ARENA_ARRAY(arena, WalkTextures, 1);
    Sides sides[ARRAYS] = {{0, 0, 0}};
    int max_side = 0, max_layers = 0;
    t->building = building;
    t->place = ARENA_ARRAY(arena, Place, building->texture_count + 1);
    if (building->texture_count == 0) return t;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &max_side);
    glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &max_layers);
    lay_out(t, max_side, max_layers, sides);
    for (int a = 0; a < ARRAYS; a++) upload_array(t, a, &sides[a]);
    upload_sky(t, max_side);
    if (gl_check("uploading pictures", error)) return t;
    walk_textures_free(t);
    return NULL;
}

void walk_textures_free(WalkTextures *t) {
    if (!t) return;
    glDeleteTextures(ARRAYS, t->array);
    glDeleteTextures(1, &t->sky);
}

// ---- polygons

int walk_textures_runs(const WalkTextures *t) { return t->array[1] ? 3 : t->array[0] ? 2 : 1; }

int walk_textures_run(const WalkTextures *t, const Polygon *polygon) {
    const Material *m = &t->building->materials[polygon->material];
    bool emits = m->emission.r + m->emission.g + m->emission.b > 0;
    if (m->texture == 0 || emits || !(polygon->texture_map || m->texture_map)) return 0;
    return t->place[m->texture].run;
}

void walk_textures_place(const WalkTextures *t, const Polygon *polygon, Vec3 first, const Vec3 *points,
                         int count, WalkPicture *out) {
    memset(out, 0, (size_t)count * sizeof *out);
    if (walk_textures_run(t, polygon) == 0) return;
    const Material *m = &t->building->materials[polygon->material];
    const TextureMap *map =
        &t->building->texture_maps[polygon->texture_map ? polygon->texture_map : m->texture_map];
    const Place *place = &t->place[m->texture];
    // Pictures repeat: places are counted from a whole number near the polygon, since floats are coarse far from 0.
    double u0 = map->u0 - floor(vec3_dot(map->u, first) + map->u0),
           v0 = map->v0 - floor(vec3_dot(map->v, first) + map->v0);
    for (int i = 0; i < count; i++) {
        out[i].place[0] = (float)(vec3_dot(map->u, points[i]) + u0);
        out[i].place[1] = (float)(vec3_dot(map->v, points[i]) + v0);
        out[i].place[2] = (float)place->layer;
        memcpy(out[i].strength, place->strength, sizeof out[i].strength);
    }
}

void walk_textures_describe(unsigned buffer) {
    glBindBuffer(GL_ARRAY_BUFFER, buffer);
    glEnableVertexAttribArray(WALK_PLACE_PICTURE);
    glVertexAttribPointer(WALK_PLACE_PICTURE, 3, GL_FLOAT, GL_FALSE, sizeof(WalkPicture),
                          (const void *)offsetof(WalkPicture, place));
    glEnableVertexAttribArray(WALK_PLACE_STRENGTH);
    glVertexAttribPointer(WALK_PLACE_STRENGTH, 4, GL_FLOAT, GL_FALSE, sizeof(WalkPicture),
                          (const void *)offsetof(WalkPicture, strength));
}

// ---- drawing

void walk_textures_bind(const WalkTextures *t, int run) {
    glActiveTexture(GL_TEXTURE0 + WALK_UNIT_PICTURES);
    glBindTexture(GL_TEXTURE_2D_ARRAY, t->array[run - 1]);
}

bool walk_textures_has_sky(const WalkTextures *t) { return t->sky != 0; }

float walk_textures_bind_sky(const WalkTextures *t, double strength[3]) {
    glActiveTexture(GL_TEXTURE0 + WALK_UNIT_PICTURES);
    glBindTexture(GL_TEXTURE_2D, t->sky);
    for (int k = 0; k < 3; k++) strength[k] = (double)t->sky_strength[k];
    return (float)t->building->sky_start;
}
