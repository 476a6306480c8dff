// texture.c - pictures, decoded by stb_image and libwebp, with smaller levels (Williams 1983, Pyramidal parametrics). sRGB is decoded
// before averaging: a chequered floor reflects the mean of its tiles' reflectances, not the reflectance of its mean code. Colours count
// by their opacity, so that the colour of what is transparent never shows.
#include "maps/building/texture.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <webp/decode.h>

#include "engine/core/memory.h"

// The most memory that decoding may ask for at once, bytes: all pixels of the largest image in four channels of 16 bits, and
// as much again since buffers grow by doubling. A chunk of a damaged PNG may claim to be longer than the file, and a small
// file may unpack to gigabytes.
static const size_t LARGEST_BUFFER = (size_t)TEXTURE_MAX_PIXELS * 4 * 2 * 2;

static void *bounded_realloc(void *old, size_t size) {
    return size <= LARGEST_BUFFER ? memory_grow(old, size) : NULL;
}
#define STBI_MALLOC(size) bounded_realloc(NULL, size)
#define STBI_REALLOC(old, size) bounded_realloc(old, size)
#define STBI_FREE(old) memory_free(old)

// GIF, PSD and the like are left out: homes have PNG and JPEG, and every decoder is one more thing to attack.
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_ONLY_BMP
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS 16384
#define STB_IMAGE_IMPLEMENTATION
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wsign-compare"
// stb_image adds 0 to null pointers on images cut short: harmless, but a sanitizer would stop there.
#ifdef __clang__
#pragma clang attribute push(__attribute__((no_sanitize("undefined"))), apply_to = function)
#endif
#include <stb/stb_image.h>
#ifdef __clang__
#pragma clang attribute pop
#endif
#pragma GCC diagnostic pop

static bool is_webp(Bytes image) {
    return image.size > 12 && memcmp(image.data, "RIFF", 4) == 0 && memcmp(image.data + 8, "WEBP", 4) == 0;
}

int texture_pixels(Bytes image) {
    int width, height, channels;
    if (image.size > INT_MAX) return 0;
    if (is_webp(image)) {
        if (!WebPGetInfo(image.data, image.size, &width, &height)) return 0;
    } else if (!stbi_info_from_memory(image.data, (int)image.size, &width, &height, &channels)) {
        return 0;
    }
    return width > 0 && height > 0 && width <= TEXTURE_MAX_PIXELS / height ? width * height : 0;
}

// The pixels of an image, counted once for every USUAL_SCANS scans of a JPEG: a progressive JPEG of a few kilobytes may go over its
// pixels a thousand times. Usual JPEGs have about ten scans.
static double work_of(Bytes image) {
    enum { USUAL_SCANS = 16 };
    int scans = 0;
    for (size_t i = 0; i + 1 < image.size; i++) scans += image.data[i] == 0xFF && image.data[i + 1] == 0xDA;
    bool jpeg = image.size > 1 && image.data[0] == 0xFF && image.data[1] == 0xD8;
    return texture_pixels(image) * (jpeg ? ceil((scans + 1.0) / USUAL_SCANS) : 1);
}

// ---- levels

// sRGB codes of linear values: a share of `CODES` to the nearest code. 4,096 steps tell all 256 codes apart but the darkest few.
enum { CODES = 4096 };
typedef struct Codes {
    float linear[256];
    uint8_t srgb[CODES + 1];
} Codes;

static void fill_codes(Codes *c) {
    for (int i = 0; i < 256; i++) {
        double s = i / 255.0;
        c->linear[i] = (float)(s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4));
    }
    for (int i = 0, code = 0; i <= CODES; i++) {
        while (code < 255 && (float)i / CODES > 0.5f * (c->linear[code] + c->linear[code + 1])) code++;
        c->srgb[i] = (uint8_t)code;
    }
}

static int half(int side) { return side > 1 ? side / 2 : 1; }

// Texels of a picture and all its smaller levels.
static size_t texels_of(int width, int height) {
    size_t sum = (size_t)width * (size_t)height;
    while (width > 1 || height > 1) {
        width = half(width), height = half(height);
        sum += (size_t)width * (size_t)height;
    }
    return sum;
}

// How much of source texel `i` lies in texel `at` of `to`, which divide the same length as `from` texels.
static double texels_shared(int i, int at, int from, int to) {
    double low = fmax((double)i * to, (double)at * from), high = fmin((i + 1.0) * to, (at + 1.0) * from);
    return fmax(high - low, 0);
}

// Writes the picture of half the sides: means over areas.
static void write_half(const Codes *codes, const uint8_t *from, int fw, int fh, uint8_t *out) {
    int w = half(fw), h = half(fh);
    for (int y = 0; y < h; y++) {
        for (int x = 0; x < w; x++) {
            double sum[3] = {0, 0, 0}, opaque = 0, all = 0;
            for (int j = y * fh / h; j < fh && j * h < (y + 1) * fh; j++) {
                for (int i = x * fw / w; i < fw && i * w < (x + 1) * fw; i++) {
                    const uint8_t *texel = from + 4 * ((size_t)j * (size_t)fw + (size_t)i);
                    double area = texels_shared(i, x, fw, w) * texels_shared(j, y, fh, h),
                           weight = area * texel[3];
                    for (int c = 0; c < 3; c++) sum[c] += weight * (double)codes->linear[texel[c]];
                    opaque += weight;
                    all += area;
                }
            }
            uint8_t *texel = out + 4 * ((size_t)y * (size_t)w + (size_t)x);
            for (int c = 0; c < 3; c++)
                texel[c] = opaque > 0 ? codes->srgb[(int)(sum[c] / opaque * CODES + 0.5)] : 0;
            texel[3] = (uint8_t)(opaque / all + 0.5);
        }
    }
}

const uint8_t *texture_level(const Texture *texture, int level, int *width, int *height) {
    const uint8_t *texels = texture->texels;
    *width = texture->width, *height = texture->height;
    for (; level > 0 && (*width > 1 || *height > 1); level--) {
        texels += 4 * (size_t)*width * (size_t)*height;
        *width = half(*width), *height = half(*height);
    }
    return texels;
}

static double texels_kept(const Building *b) {
    double sum = 0;
    for (int i = 1; i < b->texture_count; i++) sum += (double)b->textures[i].width * b->textures[i].height;
    return sum;
}

// The mean, capped texel by texel as maps_linear does; false where nothing is opaque.
static bool find_mean(const uint8_t *pixels, size_t count, Texture *out) {
    double linear[256], sum[3] = {0, 0, 0}, weight = 0;
    for (int i = 0; i < 256; i++) linear[i] = (double)maps_linear(i);
    for (size_t i = 0; i < count; i++) {
        const uint8_t *pixel = pixels + 4 * i;
        for (int c = 0; c < 3; c++) sum[c] += linear[pixel[c]] * pixel[3];
        weight += pixel[3];
    }
    if (weight <= 0) return false;
    out->mean = (Rgb){(float)(sum[0] / weight), (float)(sum[1] / weight), (float)(sum[2] / weight)};
    out->opacity = (float)(weight / 255 / (double)count);
    return true;
}

int texture_add_pixels(Arena *arena, Building *b, const char *name, int width, int height,
                       const uint8_t *pixels) {
    CORE_ASSERT(width > 0 && height > 0);
    Texture texture = {.name = arena_string(arena, name ? name : "")};
    if (!find_mean(pixels, (size_t)width * (size_t)height, &texture)) return 0;
    Codes *codes = memory_new(sizeof *codes);
    fill_codes(codes);
    double most = fmax((TEXTURE_MOST_TEXELS - texels_kept(b)) / 4, 1);
    uint8_t *smaller = NULL;
    while (width > TEXTURE_SIDE || height > TEXTURE_SIDE || (double)width * height > most) {
        int w = half(width), h = half(height);
        uint8_t *next = memory_new(4 * (size_t)w * (size_t)h);
        write_half(codes, smaller ? smaller : pixels, width, height, next);
        memory_free(smaller);
        smaller = next, width = w, height = h;
        if (width == 1 && height == 1) break;
    }
    texture.width = width, texture.height = height;
    texture.texels = arena_alloc(arena, texels_of(width, height), 4);
    memcpy(texture.texels, smaller ? smaller : pixels, 4 * (size_t)width * (size_t)height);
    memory_free(smaller);
    uint8_t *level = texture.texels;
    for (int w = width, h = height; w > 1 || h > 1; w = half(w), h = half(h)) {
        uint8_t *next = level + 4 * (size_t)w * (size_t)h;
        write_half(codes, level, w, h, next);
        level = next;
    }
    memory_free(codes);
    if (b->texture_count == 0)
        *ARENA_PUSH(arena, b->textures, b->texture_count, b->texture_capacity) = (Texture){.name = ""};
    *ARENA_PUSH(arena, b->textures, b->texture_count, b->texture_capacity) = texture;
    return b->texture_count - 1;
}

// The pixels of an image, to be freed by stbi_image_free; NULL: it may not or cannot be decoded.
static unsigned char *decode(Bytes image, double *left, int *width, int *height) {
    int channels;
    if (texture_pixels(image) == 0) return NULL;
    if (left) {
        *left += (double)image.size * TEXTURE_PIXELS_A_BYTE;
        double work = work_of(image);
        if (work > *left) return NULL;
        *left -= work;
    }
    if (!is_webp(image))
        return stbi_load_from_memory(image.data, (int)image.size, width, height, &channels, 4);
    WebPGetInfo(image.data, image.size, width, height);
    size_t size = 4 * (size_t)*width * (size_t)*height;
    unsigned char *pixels = memory_new(size);
    if (WebPDecodeRGBAInto(image.data, image.size, pixels, size, 4 * *width)) return pixels;
    memory_free(pixels);
    return NULL;
}

static int add_image(Arena *arena, Building *b, const char *name, Bytes image, double *left, bool opaque) {
    int width, height;
    unsigned char *pixels = decode(image, left, &width, &height);
    if (!pixels) return 0;
    for (size_t i = 0; opaque && i < (size_t)width * (size_t)height; i++) pixels[4 * i + 3] = 255;
    int texture = texture_add_pixels(arena, b, name, width, height, pixels);
    stbi_image_free(pixels);
    return texture;
}

int texture_add(Arena *arena, Building *b, const char *name, Bytes image, double *left) {
    return add_image(arena, b, name, image, left, false);
}

int texture_add_opaque(Arena *arena, Building *b, const char *name, Bytes image, double *left) {
    return add_image(arena, b, name, image, left, true);
}

// sRGB code of a linear value.
static uint8_t code_of(float linear) {
    double c = (double)fminf(fmaxf(linear, 0), 1);
    return (uint8_t)lrint(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055));
}

static void cut_out(unsigned char *pixels, int width, int height, const unsigned char *mask, int mw, int mh) {
    bool own = false;
    for (size_t i = 0; i < (size_t)mw * (size_t)mh && !own; i++) own = mask[4 * i + 3] < 255;
    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++) {
            size_t mx = (size_t)((2.0 * x + 1) * mw / (2.0 * width)),
                   my = (size_t)((2.0 * y + 1) * mh / (2.0 * height));
            const unsigned char *m = mask + 4 * (my * (size_t)mw + mx);
            unsigned char *pixel = pixels + 4 * ((size_t)y * (size_t)width + (size_t)x);
            pixel[3] = (unsigned char)(own ? m[3] : (m[0] + m[1] + m[2]) / 3);
        }
    }
}

int texture_add_masked(Arena *arena, Building *b, const char *name, Bytes image, Bytes mask, Rgb colour,
                       double *left) {
    if (!mask.data) return image.data ? texture_add(arena, b, name, image, left) : 0;
    int width, height, mask_width, mask_height;
    unsigned char *holes = decode(mask, left, &mask_width, &mask_height);
    if (!holes) return image.data ? texture_add(arena, b, name, image, left) : 0;
    unsigned char *pixels = image.data ? decode(image, left, &width, &height) : NULL;
    int texture = 0;
    if (pixels) {
        cut_out(pixels, width, height, holes, mask_width, mask_height);
        texture = texture_add_pixels(arena, b, name, width, height, pixels);
    } else if (!image.data) {
        cut_out(holes, mask_width, mask_height, holes, mask_width, mask_height);
        for (size_t i = 0; i < (size_t)mask_width * (size_t)mask_height; i++) {
            holes[4 * i] = code_of(colour.r);
            holes[4 * i + 1] = code_of(colour.g);
            holes[4 * i + 2] = code_of(colour.b);
        }
        texture = texture_add_pixels(arena, b, name, mask_width, mask_height, holes);
    }
    if (pixels) stbi_image_free(pixels);
    stbi_image_free(holes);
    return texture;
}

void texture_put(const Building *b, int texture, Material *material) {
    material->texture = texture;
    material->reflectance = b->textures[texture].mean;
    material->alpha *= b->textures[texture].opacity;
}

bool texture_mean(Bytes image, double *left, Rgb *mean) {
    int width, height;
    unsigned char *pixels = decode(image, left, &width, &height);
    if (!pixels) return false;
    Texture texture;
    bool good = find_mean(pixels, (size_t)width * (size_t)height, &texture);
    if (good) *mean = texture.mean;
    stbi_image_free(pixels);
    return good;
}

// ---- reading

static int wrapped(int i, int side) {
    i %= side;
    return i < 0 ? i + side : i;
}

// Adds share `share` of a level's colour, weighted by opacity, to sum[0 .. 2], and of its opacity to sum[3].
static void add_level(const Texture *texture, int level, double u, double v, double share, double sum[4]) {
    int width, height;
    const uint8_t *texels = texture_level(texture, level, &width, &height);
    double x = (u - floor(u)) * width - 0.5, y = (v - floor(v)) * height - 0.5;
    int i = (int)floor(x), j = (int)floor(y);
    for (int k = 0; k < 4; k++) {
        int right = k & 1, down = k >> 1;
        double weight = share * (right ? x - i : 1 - (x - i)) * (down ? y - j : 1 - (y - j));
        const uint8_t *texel = texels + 4 * ((size_t)wrapped(j + down, height) * (size_t)width +
                                             (size_t)wrapped(i + right, width));
        double opaque = weight * texel[3] / 255;
        for (int c = 0; c < 3; c++) sum[c] += opaque * (double)maps_linear(texel[c]);
        sum[3] += opaque;
    }
}

Texel texture_read(const Texture *texture, double u, double v, double texels) {
    double sum[4] = {0, 0, 0, 0}, level = texels > 1 ? fmin(log2(texels), 30) : 0;
    int finer = (int)level;
    add_level(texture, finer, u, v, 1 - (level - finer), sum);
    if (level > finer) add_level(texture, finer + 1, u, v, level - finer, sum);
    if (!(sum[3] > 0)) return (Texel){texture->mean, 0};
    return (Texel){{(float)(sum[0] / sum[3]), (float)(sum[1] / sum[3]), (float)(sum[2] / sum[3])},
                   (float)fmin(sum[3], 1)};
}

// A channel of a material whose picture has `mean`, where the picture has `texel`. Nothing above MAPS_MAX_REFLECTANCE is reflected.
static float in_proportion(float reflectance, float texel, float mean) {
    return mean > 0 ? fminf(reflectance * texel / mean, MAPS_MAX_REFLECTANCE) : reflectance;
}

Texel texture_at(const Building *b, int material, int texture_map, Vec3 p, double width) {
    const Material *m = &b->materials[material];
    int map = texture_map ? texture_map : m->texture_map;
    if (m->texture == 0 || map == 0) return (Texel){m->reflectance, 1};
    const Texture *texture = &b->textures[m->texture];
    const TextureMap *t = &b->texture_maps[map];
    double u = vec3_dot(t->u, p) + t->u0, v = vec3_dot(t->v, p) + t->v0;
    double texels = width * fmax(vec3_length(t->u) * texture->width, vec3_length(t->v) * texture->height);
    Texel at = texture_read(texture, u, v, texels);
    Rgb r = m->reflectance, mean = texture->mean;
    return (Texel){{in_proportion(r.r, at.colour.r, mean.r), in_proportion(r.g, at.colour.g, mean.g),
                    in_proportion(r.b, at.colour.b, mean.b)},
                   at.opacity};
}
