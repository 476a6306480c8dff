// overlay.h - text and flat shapes over a frame, antialiased; plans are drawn through the drawing table.
//
// Works in the current OpenGL context, in which it was made. Positions and sizes are in points from the top left, y down; a
// point is `scale` pixels. Row 0 of the framebuffer is its top. Later drawing lies over earlier drawing. Shapes in a row are
// one draw call, and so is text in a row, as long as all of them are clipped alike.
#ifndef WALK_OVERLAY_H
#define WALK_OVERLAY_H

#include "engine/core/draw.h"
#include "engine/core/error.h"

typedef struct Overlay Overlay;

Overlay *overlay_new(Arena *arena, Error *error);
void overlay_free(Overlay *overlay);  // NULL is allowed

// Starts a frame of `width` x `height` pixels.
void overlay_begin(Overlay *overlay, int width, int height, double scale);
// Draws the frame into the framebuffer that is bound. Sets all the state it needs and leaves scissors and blending off.
bool overlay_end(Overlay *overlay, Error *error);

double overlay_width(const Overlay *overlay);  // of the frame, points
double overlay_height(const Overlay *overlay);
double overlay_scale(const Overlay *overlay);  // pixels to a point

// From overlay_clip until overlay_unclip, drawing shows inside this rectangle only, to the nearest pixel.
void overlay_clip(Overlay *overlay, double x, double y, double width, double height);
void overlay_unclip(Overlay *overlay);

// Colours are 0xRRGGBB, opacity is 0 .. 1. Rectangles lie on whole pixels.
void overlay_rectangle(Overlay *overlay, double x, double y, double width, double height, double radius,
                       unsigned rgb, double opacity);
// A line with round ends. A line thinner than a pixel is drawn a pixel wide and paler.
void overlay_line(Overlay *overlay, Vec2 a, Vec2 b, double width, unsigned rgb, double opacity);
void overlay_circle(Overlay *overlay, Vec2 centre, double radius, unsigned rgb, double opacity);
// A convex polygon. Its edges are not smoothed, so that neighbours meet without a seam; lines smooth them where needed.
void overlay_polygon(Overlay *overlay, const Vec2 *points, int count, unsigned rgb, double opacity);

// Text in UTF-8, `size` points to the em. `baseline` is moved to the nearest whole pixel.
void overlay_text(Overlay *overlay, double x, double baseline, double size, unsigned rgb, double opacity,
                  const char *utf8);
double overlay_text_width(Overlay *overlay, double size, const char *utf8);
// Bytes of the longest start of the text that is not wider than `width`.
size_t overlay_text_fit(Overlay *overlay, double size, const char *utf8, double width);

// The height of capitals over the baseline, as a share of the em.
#define OVERLAY_CAPITALS 0.73

// A window onto a plan: shows `area` of plan space in the middle of a rectangle, as large as it fits there, north up.
typedef struct OverlayMap {
    Overlay *overlay;
    double x, y, width, height;  // points
    Vec2 middle;                 // of the area, metres
    double scale;                // points per metre
} OverlayMap;
OverlayMap overlay_map(Overlay *overlay, Box area, double x, double y, double width, double height);
// A drawing table that draws through the map, clipped to the map's rectangle. Valid as long as the map.
Draw overlay_map_draw(OverlayMap *map);

#endif
