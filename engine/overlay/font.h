// font.h - glyphs of DejaVu Sans as coverage, each rasterised once at the pixel size it is shown at, in one image.
//
// The font file is part of the program (the Makefile says where from). Knows no OpenGL: the overlay uploads the image.
#ifndef WALK_FONT_H
#define WALK_FONT_H

#include <stdbool.h>
#include <stdint.h>

#include "engine/core/arena.h"

// Sizes are of the em, in pixels; others are moved to the nearest of these.
#define FONT_SMALLEST 5
#define FONT_LARGEST 128
// Glyphs are rasterised at this many places within a pixel, so that letters stand evenly.
#define FONT_STEPS 4

typedef struct Glyph {
    int index;                // in the font file, for kerning
    int x, y, width, height;  // in the image; width 0: nothing to draw
    int left, top;            // from the pen, on the baseline, to its first pixel; y down
    float advance;            // pixels
} Glyph;

typedef struct FontImage {
    const uint8_t *coverage;   // [height * width], rows from the top
    int width, height;         // the height grows
    int first_row, row_count;  // changed since the last font_image
} FontImage;

typedef struct Font Font;

Font *font_new(Arena *arena);

// The next character of UTF-8, and moves on; U+FFFD for each byte that belongs to none. 0 at the end, and stays there.
int font_decode(const char **utf8);

// The glyph of a character that starts `step` / FONT_STEPS of a pixel right of a whole one; a box where the font has
// none. Valid until the next call. Empty where the image is full: the next font_trim makes room.
Glyph font_glyph(Font *font, int character, int size, int step);
double font_kerning(const Font *font, const Glyph *a, const Glyph *b, int size);  // pixels, before b

// Before each frame: throws all glyphs away if they no longer fit.
void font_trim(Font *font);
FontImage font_image(Font *font);

#endif
