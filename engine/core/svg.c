// svg.c - the SVG back end of the drawing table.
#include <stdarg.h>
#include <stdio.h>

#include "engine/core/draw.h"

struct SvgDrawing {
    Arena *arena;
    char *text;
    size_t length, capacity;
    double x0, y1, scale;  // plan (x, y) is drawn at ((x - x0) * scale, (y1 - y) * scale)
};

static void append(SvgDrawing *svg, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void append(SvgDrawing *svg, const char *format, ...) {
    va_list args, again;
    va_start(args, format);
    va_copy(again, args);
    size_t need = (size_t)vsnprintf(NULL, 0, format, args) + 1;
    if (svg->length + need > svg->capacity) {
        svg->capacity = 2 * (svg->capacity + need);
        char *larger = arena_alloc(svg->arena, svg->capacity, 1);
        if (svg->length) memcpy(larger, svg->text, svg->length);
        svg->text = larger;
    }
    vsnprintf(svg->text + svg->length, need, format, again);
    svg->length += need - 1;
    va_end(again);
    va_end(args);
}

SvgDrawing *svg_begin(Arena *arena, Box bounds, int pixels) {
    SvgDrawing *svg = arena_alloc(arena, 1, sizeof *svg);
    double width = bounds.max.x - bounds.min.x, height = bounds.max.y - bounds.min.y;
    *svg = (SvgDrawing){.arena = arena, .x0 = bounds.min.x, .y1 = bounds.max.y, .scale = pixels / width};
    append(svg,
           "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%.0f\" viewBox=\"0 0 %d %.0f\">\n"
           "<rect width=\"100%%\" height=\"100%%\" fill=\"#ffffff\"/>\n",
           pixels, height * svg->scale, pixels, height * svg->scale);
    return svg;
}

static void append_style(SvgDrawing *svg, const DrawStyle *style) {
    if (style->fill_opacity > 0) {
        append(svg, " fill=\"#%06x\" fill-opacity=\"%.3g\"", style->fill, style->fill_opacity);
    } else {
        append(svg, " fill=\"none\"");
    }
    if (style->width > 0) {
        append(svg,
               " stroke=\"#%06x\" stroke-width=\"%.2f\" stroke-linecap=\"round\" stroke-linejoin=\"round\"",
               style->stroke, style->width * svg->scale);
        if (style->dash > 0) append(svg, " stroke-dasharray=\"%.2f\"", style->dash * svg->scale);
    }
    append(svg, "/>\n");
}

static double px(const SvgDrawing *svg, Vec2 p) { return (p.x - svg->x0) * svg->scale; }
static double py(const SvgDrawing *svg, Vec2 p) { return (svg->y1 - p.y) * svg->scale; }

static void draw_polygon(void *context, const Vec2 *points, int count, const DrawStyle *style) {
    SvgDrawing *svg = context;
    append(svg, "<polygon points=\"");
    for (int i = 0; i < count; i++) append(svg, "%.2f,%.2f ", px(svg, points[i]), py(svg, points[i]));
    append(svg, "\"");
    append_style(svg, style);
}

static void draw_line(void *context, Vec2 a, Vec2 b, const DrawStyle *style) {
    SvgDrawing *svg = context;
    append(svg, "<line x1=\"%.2f\" y1=\"%.2f\" x2=\"%.2f\" y2=\"%.2f\"", px(svg, a), py(svg, a), px(svg, b),
           py(svg, b));
    append_style(svg, style);
}

static void draw_circle(void *context, Vec2 centre, double radius, const DrawStyle *style) {
    SvgDrawing *svg = context;
    append(svg, "<circle cx=\"%.2f\" cy=\"%.2f\" r=\"%.2f\"", px(svg, centre), py(svg, centre),
           radius * svg->scale);
    append_style(svg, style);
}

static void draw_text(void *context, Vec2 at, double size, unsigned colour, const char *text) {
    SvgDrawing *svg = context;
    append(svg,
           "<text x=\"%.2f\" y=\"%.2f\" font-family=\"sans-serif\" font-size=\"%.2f\" text-anchor=\"middle\" "
           "dominant-baseline=\"central\" fill=\"#%06x\">",
           px(svg, at), py(svg, at), size * svg->scale, colour);
    for (const char *c = text; *c; c++) {
        switch (*c) {
        case '<':
            append(svg, "&lt;");
            break;
        case '>':
            append(svg, "&gt;");
            break;
        case '&':
            append(svg, "&amp;");
            break;
        default:
            if ((unsigned char)*c >= 0x20) append(svg, "%c", *c);  // XML knows no other control characters
        }
    }
    append(svg, "</text>\n");
}

Draw svg_draw(SvgDrawing *svg) { return (Draw){draw_polygon, draw_line, draw_circle, draw_text, svg}; }

const char *svg_end(SvgDrawing *svg) {
    append(svg, "</svg>\n");
    return svg->text;
}
