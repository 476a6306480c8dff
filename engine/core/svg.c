// svg.c - the SVG back end of the drawing table.
#include "engine/core/draw.h"
#include "engine/core/text.h"

struct SvgDrawing {
    Text text;
    double x0, y1, scale;  // plan (x, y) is drawn at ((x - x0) * scale, (y1 - y) * scale)
};

SvgDrawing *svg_begin(Arena *arena, Box bounds, int pixels) {
    SvgDrawing *svg = arena_alloc(arena, 1, sizeof *svg);
    double width = bounds.max.x - bounds.min.x, height = bounds.max.y - bounds.min.y;
    *svg = (SvgDrawing){
        .text = {.arena = arena}, .x0 = bounds.min.x, .y1 = bounds.max.y, .scale = pixels / width};
    text_append(
        &svg->text,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%.0f\" viewBox=\"0 0 %d %.0f\">\n"
        "<rect width=\"100%%\" height=\"100%%\" fill=\"#ffffff\"/>\n",
        pixels, height * svg->scale, pixels, height * svg->scale);
    return svg;
}

static void append_style(SvgDrawing *svg, const DrawStyle *style) {
    if (style->fill_opacity > 0) {
        text_append(&svg->text, " fill=\"#%06x\" fill-opacity=\"%.3g\"", style->fill, style->fill_opacity);
    } else {
        text_append(&svg->text, " fill=\"none\"");
    }
    if (style->width > 0) {
        text_append(
            &svg->text,
            " stroke=\"#%06x\" stroke-width=\"%.2f\" stroke-linecap=\"round\" stroke-linejoin=\"round\"",
            style->stroke, style->width * svg->scale);
        if (style->dash > 0) text_append(&svg->text, " stroke-dasharray=\"%.2f\"", style->dash * svg->scale);
    }
    text_append(&svg->text, "/>\n");
}

static double px(const SvgDrawing *svg, Vec2 p) { return (p.x - svg->x0) * svg->scale; }
static double py(const SvgDrawing *svg, Vec2 p) { return (svg->y1 - p.y) * svg->scale; }

static void draw_polygon(void *context, const Vec2 *points, int count, const DrawStyle *style) {
    SvgDrawing *svg = context;
    text_append(&svg->text, "<polygon points=\"");
    for (int i = 0; i < count; i++)
        text_append(&svg->text, "%.2f,%.2f ", px(svg, points[i]), py(svg, points[i]));
    text_append(&svg->text, "\"");
    append_style(svg, style);
}

static void draw_line(void *context, Vec2 a, Vec2 b, const DrawStyle *style) {
    SvgDrawing *svg = context;
    text_append(&svg->text, "<line x1=\"%.2f\" y1=\"%.2f\" x2=\"%.2f\" y2=\"%.2f\"", px(svg, a), py(svg, a),
                px(svg, b), py(svg, b));
    append_style(svg, style);
}

static void draw_circle(void *context, Vec2 centre, double radius, const DrawStyle *style) {
    SvgDrawing *svg = context;
    text_append(&svg->text, "<circle cx=\"%.2f\" cy=\"%.2f\" r=\"%.2f\"", px(svg, centre), py(svg, centre),
                radius * svg->scale);
    append_style(svg, style);
}

static void draw_text(void *context, Vec2 at, double size, unsigned colour, const char *text) {
    SvgDrawing *svg = context;
    text_append(
        &svg->text,
        "<text x=\"%.2f\" y=\"%.2f\" font-family=\"sans-serif\" font-size=\"%.2f\" text-anchor=\"middle\" "
        "dominant-baseline=\"central\" fill=\"#%06x\">",
        px(svg, at), py(svg, at), size * svg->scale, colour);
    for (const char *c = text; *c; c++) {
        switch (*c) {
        case '<':
            text_append(&svg->text, "&lt;");
            break;
        case '>':
            text_append(&svg->text, "&gt;");
            break;
        case '&':
            text_append(&svg->text, "&amp;");
            break;
        default:
            if ((unsigned char)*c >= 0x20)
                text_append(&svg->text, "%c", *c);  // XML does not allow most control characters
        }
    }
    text_append(&svg->text, "</text>\n");
}

Draw svg_draw(SvgDrawing *svg) { return (Draw){draw_polygon, draw_line, draw_circle, draw_text, svg, NULL}; }

const char *svg_end(SvgDrawing *svg) {
    text_append(&svg->text, "</svg>\n");
    return svg->text.data;
}
