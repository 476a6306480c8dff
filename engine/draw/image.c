// image.c - PNG by libpng's simplified interface.
#include "engine/draw/image.h"

#include <png.h>

#include "engine/core/memory.h"

// The largest file and the largest image, bytes: enough for a frame of 16,384 x 16,384 pixels.
#define IMAGE_LIMIT ((size_t)1 << 30)

bool image_write_png(const char *path, const uint8_t *rgb, int width, int height, Error *error) {
    // Tour frames are written by the hundred: speed matters more than size.
    png_image image = {.version = PNG_IMAGE_VERSION,
                       .width = (png_uint_32)width,
                       .height = (png_uint_32)height,
                       .format = PNG_FORMAT_RGB,
                       .flags = PNG_IMAGE_FLAG_FAST};
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
    void *memory = memory_new(size);
    bool good = png_image_write_to_memory(&image, memory, &size, 0, rgb, 0, NULL);
    good =
        good ? file_write(path, memory, size, error) : error_set(error, "%s: PNG: %s", path, image.message);
    memory_free(memory);
    return good;
}

bool image_read_png(const char *path, Arena *arena, uint8_t **rgb, int *width, int *height, Error *error) {
    Bytes bytes;
    if (!file_read(path, IMAGE_LIMIT, arena, &bytes, error)) return false;
    png_image image = {.version = PNG_IMAGE_VERSION};
    if (!png_image_begin_read_from_memory(&image, bytes.data, bytes.size)) {
        return error_set(error, "%s: PNG: %s", path, image.message);
    }
    image.format = PNG_FORMAT_RGB;
    if (PNG_IMAGE_SIZE(image) > IMAGE_LIMIT) {
        png_image_free(&image);
        return error_set(error, "%s: an image of %u x %u pixels (limit %zu bytes)", path, image.width,
                         image.height, IMAGE_LIMIT);
    }
    *rgb = arena_alloc(arena, PNG_IMAGE_SIZE(image), 1);
    *width = (int)image.width;
    *height = (int)image.height;
    if (!png_image_finish_read(&image, NULL, *rgb, 0, NULL)) {
        return error_set(error, "%s: PNG: %s", path, image.message);
    }
    return true;
}
