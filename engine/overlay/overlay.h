// overlay.h - text and flat shapes over a frame, antialiased, and plans through the drawing table.
//
// Works in the current OpenGL context, in which it was made. Everything is in points from the top left, y down; a
// point is `scale` pixels. Row 0 of the framebuffer is its top. What is drawn later lies over what was drawn before.
// Shapes in a row are one draw call, and so is text in a row, as long as both are clipped alike.
#ifndef WALK_OVERLAY_H
#define WALK_OVERLAY_H

#include "engine/core/draw.h"
#include "engine/core/error.h"

typedef struct Overlay Overlay;

Overlay *overlay_new(Arena *arena, Error *error);
void overlay_free(Overlay *overlay);  // NULL is allowed

// Starts a frame of `width` x `height` pixels.
void overlay_begin(Overlay *overlay, int width, int height, double scale);
// Draws it into the framebuffer that is bound. Sets all the state it needs and leaves scissors and blending off.
bool overlay_end(Overlay *overlay, Error *error);

double overlay_width(const Overlay *overlay);  // of the frame, points
double overlay_height(const Overlay *overlay);

// Drawing from now on shows inside this rectangle only, to the nearest pixel; the second one ends it.
void overlay_clip(Overlay *overlay, double x, double y, double width, double height);
void overlay_unclip(Overlay *overlay);

// Colours are 0xRRGGBB, opacity is 0..1. Rectangles lie on whole pixels.
void overlay_rectangle(Overlay *overlay, double x, double y, double width, double height, double radius,
                       unsigned rgb, double opacity);
// With round ends. Thinner than a pixel it is a pixel wide and paler.
void overlay_line(Overlay *overlay, Vec2 a, Vec2 b, double width, unsigned rgb, double opacity);
void overlay_circle(Overlay *overlay, Vec2 centre, double radius, unsigned rgb, double opacity);
// Convex. Its edges are not smoothed, so that neighbours meet without a seam: lines do that.
void overlay_polygon(Overlay *overlay, const Vec2 *points, int count, unsigned rgb, double opacity);

// UTF-8, `size` points to the em. `baseline` is moved to the next whole pixel.
void overlay_text(Overlay *overlay, double x, double baseline, double size, unsigned rgb, double opacity,
                  const char *utf8);
double overlay_text_width(Overlay *overlay, double size, const char *utf8);
// Bytes of the longest start of the text that is not wider than `width`.
size_t overlay_text_fit(Overlay *overlay, double size, const char *utf8, double width);

// A share of the em: how high capitals reach over the baseline.
#define OVERLAY_CAPITALS 0.73

// A window onto a plan: `area` of plan space as large as fits into a rectangle, in its middle, north up.
typedef struct OverlayMap {
    Overlay *overlay;
    double x, y, width, height;  // points
    Vec2 middle;                 // of the area, metres
    double scale;                // points per metre
} OverlayMap;
OverlayMap overlay_map(Overlay *overlay, Box area, double x, double y, double width, double height);
// Draws through the map, clipped to its rectangle. Valid as long as the map.
Draw overlay_map_draw(OverlayMap *map);

#endif
