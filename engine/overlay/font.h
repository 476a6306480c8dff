// font.h - glyphs of DejaVu Sans as coverage, in one image; each is rasterised once, at the pixel size it is shown at.
//
// The font file is part of the program (the Makefile says where it is from). This code knows no OpenGL: the overlay uploads the image.
#ifndef WALK_FONT_H
#define WALK_FONT_H

#include <stdbool.h>
#include <stdint.h>

#include "engine/core/arena.h"

// Sizes are those of the em, in pixels; a size outside these bounds becomes the nearest of them.
#define FONT_SMALLEST 5
#define FONT_LARGEST 128
// Glyphs are rasterised at this many horizontal offsets within a pixel, so that letters stand evenly.
#define FONT_STEPS 4

typedef struct Glyph {
    int index;                // in the font file, for kerning
    int x, y, width, height;  // in the image; width 0: nothing to draw
    int left, top;            // from the pen, on the baseline, to the glyph's first pixel; y down
    float advance;            // pixels
} Glyph;

typedef struct FontImage {
    const uint8_t *coverage;   // [height * width], rows from the top
    int width, height;         // the height grows
    int first_row, row_count;  // rows that changed since the last font_image
} FontImage;

typedef struct Font Font;

Font *font_new(Arena *arena);

// Returns the next character of UTF-8 and moves on past it; U+FFFD for each byte that belongs to no character. At the end of the text it
// returns 0 and stays there.
int font_decode(const char **utf8);

// The glyph of a character that starts `step` / FONT_STEPS of a pixel right of a whole one; a box where the font lacks the character.
// Valid until the next call. The glyph is empty where the image is full: the next font_trim makes room.
Glyph font_glyph(Font *font, int character, int size, int step);
double font_kerning(const Font *font, const Glyph *a, const Glyph *b, int size);  // pixels, to add before b

// Call before each frame: throws all glyphs away if the image was full.
void font_trim(Font *font);
FontImage font_image(Font *font);

#endif
