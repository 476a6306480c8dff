// texture.c - mean colours of images, decoded by stb_image. sRGB is decoded before averaging: a chequered floor
// reflects the mean of its tiles' reflectances, not the reflectance of its mean code.
#include "maps/building/texture.h"

#include <limits.h>
#include <stdlib.h>

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

int texture_pixels(Bytes image) {
    int width, height, channels;
    if (image.size > INT_MAX) return 0;
    if (!stbi_info_from_memory(image.data, (int)image.size, &width, &height, &channels)) return 0;
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

bool texture_mean(Bytes image, double *left, Rgb *mean) {
    int width, height, channels;
    if (texture_pixels(image) == 0) return false;
    if (left) {
        *left += (double)image.size * TEXTURE_PIXELS_A_BYTE;
        double work = work_of(image);
        if (work > *left) return false;
        *left -= work;
    }
    unsigned char *pixels = stbi_load_from_memory(image.data, (int)image.size, &width, &height, &channels, 4);
    if (!pixels) return false;
    double linear[256], sum[3] = {0}, weight = 0;
    for (int i = 0; i < 256; i++) linear[i] = (double)maps_linear(i);
    size_t count = (size_t)width * (size_t)height;
    for (size_t i = 0; i < count; i++) {
        const unsigned char *pixel = pixels + 4 * i;
        for (int c = 0; c < 3; c++) sum[c] += linear[pixel[c]] * pixel[3];
        weight += pixel[3];
    }
    stbi_image_free(pixels);
    if (weight <= 0) return false;
    *mean = (Rgb){(float)(sum[0] / weight), (float)(sum[1] / weight), (float)(sum[2] / weight)};
    return true;
}
