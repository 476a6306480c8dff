// display_offscreen.c - a display in memory (OSMesa): events come from a list of cues, frames go to a framebuffer that can
// be read. Its clock advances by frames, so nothing depends on how fast the machine is.
#include <glad/gl.h>

#include "engine/display/display_back_end.h"
#include "engine/gl/gl_context.h"

// The frames in a second of the display's clock.
static const double FRAMES_PER_SECOND = 60;

typedef struct Offscreen {
    GlContext *context;
    DisplaySize size;
    unsigned framebuffer, colour;
    const DisplayCue *cues;
    int cue_count, next_cue;
    long presented;
} Offscreen;

static bool resize(Offscreen *o, int width, int height, Error *error) {
    o->size.width = width;
    o->size.height = height;
    glBindRenderbuffer(GL_RENDERBUFFER, o->colour);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width > 0 ? width : 1, height > 0 ? height : 1);
    return gl_check("making an off-screen frame", error);
}

static bool open_offscreen(Display *display, const DisplayOptions *options, Arena *arena, Error *error) {
    Offscreen *o = display->own = ARENA_ARRAY(arena, Offscreen, 1);
    *o = (Offscreen){
        .size = {.scale = options->scale}, .cues = options->cues, .cue_count = options->cue_count};
    o->context = gl_context_open(arena, error);
    if (!o->context) return false;
    glGenFramebuffers(1, &o->framebuffer);
    glGenRenderbuffers(1, &o->colour);
    int width = (int)(options->width * options->scale + 0.5),
        height = (int)(options->height * options->scale + 0.5);
    if (resize(o, width, height, error)) {
        glBindFramebuffer(GL_FRAMEBUFFER, o->framebuffer);
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, o->colour);
        return true;
    }
    gl_context_close(o->context);
    return false;
}

static void close_offscreen(Display *display) {
    Offscreen *o = display->own;
    gl_context_close(o->context);
}

static DisplaySize offscreen_size(const Display *display) {
    const Offscreen *o = display->own;
    return o->size;
}

static unsigned framebuffer_of(const Display *display) {
    const Offscreen *o = display->own;
    return o->framebuffer;
}

static double seconds_of(const Display *display) {
    const Offscreen *o = display->own;
    return (double)o->presented / FRAMES_PER_SECOND;
}

static void offscreen_gather(Display *display) {
    Offscreen *o = display->own;
    double now = seconds_of(display);
    for (; o->next_cue < o->cue_count && o->cues[o->next_cue].at <= now; o->next_cue++) {
        DisplayEvent event = o->cues[o->next_cue].event;
        // If a size does not fit in memory, drawing the next frame fails.
        if (event.kind == DISPLAY_RESIZED) resize(o, (int)event.x, (int)event.y, NULL);
        display_push(display, event);
    }
}

static void present(Display *display) {
    Offscreen *o = display->own;
    glFinish();
    o->presented++;
}

static void no_wait(Display *display, double seconds) { (void)display, (void)seconds; }
static void no_wake(Display *display) { (void)display; }
static void nothing(Display *display, bool on) { (void)display, (void)on; }
static void no_title(Display *display, const char *title) { (void)display, (void)title; }

const DisplayBackEnd DISPLAY_OFFSCREEN = {"offscreen",      "in memory, by OSMesa",
                                          open_offscreen,   close_offscreen,
                                          offscreen_size,   framebuffer_of,
                                          offscreen_gather, present,
                                          no_wait,          no_wake,
                                          seconds_of,       nothing,
                                          nothing,          no_title};
