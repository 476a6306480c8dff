// overlay_fixture.c - see the header.
#include "tests/overlay/overlay_fixture.h"

#include <criterion/criterion.h>
#include <glad/gl.h>

#include "engine/core/random.h"
#include "engine/gl/gl_context.h"
#include "engine/overlay/font.h"
#include "engine/overlay/hud.h"
#include "maps/maps.h"
#include "visibility/prepare/figure.h"

void overlay_check_canvas_open(Canvas *c, int width, int height) {
    *c = (Canvas){.width = width, .height = height};
    Error error;
    c->context = gl_context_open(&c->arena, &error);
    cr_assert(c->context, "%s", error.text);
    c->overlay = overlay_new(&c->arena, &error);
    cr_assert(c->overlay, "%s", error.text);
    glGenRenderbuffers(1, &c->target);
    glBindRenderbuffer(GL_RENDERBUFFER, c->target);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);
    glGenFramebuffers(1, &c->frame);
    glBindFramebuffer(GL_FRAMEBUFFER, c->frame);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, c->target);
    c->rgba = arena_alloc(&c->arena, (size_t)width * (size_t)height, 4);
}

void overlay_check_canvas_close(Canvas *c) {
    overlay_free(c->overlay);
    gl_context_close(c->context);
    arena_free(&c->arena);
}

void overlay_check_canvas_begin(Canvas *c, double scale) {
    glClearColor(0, 0, 0, 1);
    glClear(GL_COLOR_BUFFER_BIT);
    overlay_begin(c->overlay, c->width, c->height, scale);
}

void overlay_check_canvas_end(Canvas *c) {
    Error error;
    cr_assert(overlay_end(c->overlay, &error), "%s", error.text);
    glReadPixels(0, 0, c->width, c->height, GL_RGBA, GL_UNSIGNED_BYTE, c->rgba);
}

const uint8_t *overlay_check_pixel(const Canvas *c, double x, double y) {
    cr_assert(x >= 0 && y >= 0 && x < c->width && y < c->height, "no pixel (%g, %g)", x, y);
    return c->rgba + 4 * ((size_t)y * (size_t)c->width + (size_t)x);
}

double overlay_check_covered(const Canvas *c) {
    double sum = 0;
    for (int i = 0; i < c->width * c->height; i++) sum += c->rgba[4 * i] / 255.0;
    return sum;
}

Ink overlay_check_ink_of(const Canvas *c) {
    Ink ink = {c->width, -1, c->height, -1};
    for (int y = 0; y < c->height; y++) {
        for (int x = 0; x < c->width; x++) {
            if (overlay_check_pixel(c, x, y)[0] < 16)
                continue;  // the faintest edge of a letter, and dark panels
            if (x < ink.x0) ink.x0 = x;
            if (x > ink.x1) ink.x1 = x;
            if (y < ink.y0) ink.y0 = y;
            if (y > ink.y1) ink.y1 = y;
        }
    }
    return ink;
}

void overlay_check_open_home(Home *h, Arena *arena, const char *path) {
    Error error;
    VisOptions options = vis_default_options();
    cr_assert(maps_read(path, arena, &h->building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&h->building, &options, arena, &h->graph, &error), "%s", error.text);
    cr_assert(vis_build_forest(&h->graph, &options, NULL, arena, &h->forest));
    h->places = plan_places(&h->graph, arena);
}

PlanView overlay_check_view_from(const Home *h, Vec3 eye, double yaw) {
    int cell = vis_locate(&h->graph, eye, -1);
    return (PlanView){.graph = &h->graph,
                      .places = h->places,
                      .eye = eye,
                      .yaw = yaw,
                      .fov = 1.2,
                      .cell = cell,
                      .storey = plan_view_storey(&h->graph, cell, eye)};
}
