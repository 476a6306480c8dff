// draw.h - debug and figure drawing as one table of function pointers, so that one drawing routine can draw the plan into a file or
// the overlay onto the screen and, without a table, draws nothing.
#ifndef CORE_DRAW_H
#define CORE_DRAW_H

#include "engine/core/arena.h"
#include "engine/core/vec.h"

typedef struct DrawStyle {
    unsigned stroke, fill;  // 0xRRGGBB; width 0 leaves the line out, fill_opacity 0 the fill
    double width;           // of the line, metres in plan space
    double fill_opacity;    // 0..1
    double dash;            // dash length in metres, 0 = solid
} DrawStyle;

typedef struct Draw {
    void (*polygon)(void *context, const Vec2 *points, int count, const DrawStyle *style);
    void (*line)(void *context, Vec2 a, Vec2 b, const DrawStyle *style);
    void (*circle)(void *context, Vec2 centre, double radius, const DrawStyle *style);
    // Centred at `at`, `size` metres high.
    void (*text)(void *context, Vec2 at, double size, unsigned colour, const char *text);
    void *context;
    double (*text_width)(void *context, double size, const char *text);  // metres; NULL: not known
} Draw;

typedef struct SvgDrawing SvgDrawing;

// Begins a drawing in memory: the part of plan space in `bounds` (z is not used), y up, `pixels` wide.
SvgDrawing *svg_begin(Arena *arena, Box bounds, int pixels);
Draw svg_draw(SvgDrawing *svg);
const char *svg_end(SvgDrawing *svg);  // the whole document, in the arena

#endif
