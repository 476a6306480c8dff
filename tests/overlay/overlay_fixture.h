// overlay_fixture.h - an overlay drawn to memory.
#ifndef TESTS_OVERLAY_FIXTURE_H
#define TESTS_OVERLAY_FIXTURE_H

#include "engine/gl/gl_context.h"
#include "engine/overlay/hud.h"

// A black frame and an overlay to draw on it.
typedef struct Canvas {
    Arena arena;
    GlContext *context;
    Overlay *overlay;
    unsigned frame, target;
    int width, height;
    uint8_t *rgba;  // as read last, rows from the top
} Canvas;

void overlay_check_canvas_open(Canvas *c, int width, int height);

void overlay_check_canvas_close(Canvas *c);

void overlay_check_canvas_begin(Canvas *c, double scale);

void overlay_check_canvas_end(Canvas *c);

const uint8_t *overlay_check_pixel(const Canvas *c, double x, double y);

// How many pixels are covered, parts of pixels counted as such: white on black.
double overlay_check_covered(const Canvas *c);

// The pixels in which there is red: first and last column, first and last row.
typedef struct Ink {
    int x0, x1, y0, y1;
} Ink;

Ink overlay_check_ink_of(const Canvas *c);

typedef struct Home {
    PlanPlaces *places;
    Building building;
    CellGraph graph;
    StabForest forest;
} Home;

void overlay_check_open_home(Home *h, Arena *arena, const char *path);

PlanView overlay_check_view_from(const Home *h, Vec3 eye, double yaw);

#endif
