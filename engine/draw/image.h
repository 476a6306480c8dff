// image.h - reads and writes PNG files.
#ifndef WALK_IMAGE_H
#define WALK_IMAGE_H

#include <stdint.h>

#include "engine/core/file.h"

// `rgb` [height * width * 3] is sRGB, rows from the top. A written file appears whole or not at all.
bool image_write_png(const char *path, const uint8_t *rgb, int width, int height, Error *error);
bool image_read_png(const char *path, Arena *arena, uint8_t **rgb, int *width, int *height, Error *error);

#endif
