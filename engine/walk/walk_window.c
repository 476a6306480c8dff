// walk_window.c - the loop: events go in, time goes on, and a frame comes out where it would show anything new. Else the loop sleeps.
// Before the loop the building is read while the window opens; the window shows a bar, then the first picture.
#include "engine/walk/walk_window.h"

#include <glad/gl.h>
#include <math.h>
#include <stdatomic.h>

// The bar that shows that a building is being read: its share of the window's width, its height in pixels, the time in which its bright
// part goes to and fro, and the time between two pictures of it, seconds.
static const double BAR_WIDTH = 0.3, BAR_PERIOD = 1.6, BAR_EVERY = 0.05;
enum { BAR_HEIGHT = 6 };

// ---- before the building is there

static void fill(int x, int y, int width, int height, float grey) {
    glScissor(x, y, width, height);
    glClearColor(grey, 1.05f * grey, 1.1f * grey, 1);
    glClear(GL_COLOR_BUFFER_BIT);
}

// Drawn by clearing parts of the window, since no shader is compiled yet.
static void draw_bar(Display *display, double seconds) {
    DisplaySize size = display_size(display);
    if (size.width < 1 || size.height < 1) return;
    int width = (int)(BAR_WIDTH * size.width), x = (size.width - width) / 2, y = size.height / 2;
    double phase = fabs(remainder(seconds, BAR_PERIOD)) / (BAR_PERIOD / 2);
    glBindFramebuffer(GL_FRAMEBUFFER, display_framebuffer(display));
    glEnable(GL_SCISSOR_TEST);
    fill(0, 0, size.width, size.height, 0.07f);
    fill(x, y, width, BAR_HEIGHT, 0.2f);
    fill(x + (int)(phase * 0.75 * width), y, width / 4 + 1, BAR_HEIGHT, 0.7f);
    glDisable(GL_SCISSOR_TEST);
    display_present(display);
}

static void show_picture(Display *display, const SessionPicture *picture) {
    DisplaySize size = display_size(display);
    unsigned texture, framebuffer;
    if (size.width < 1 || size.height < 1) return;
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    // As the renderer's final frame, whose rows come from the top, too: showing it in its own size is a plain copy. From the bottom a
    // shader would turn it over, which takes longer to compile than such a picture to draw.
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, picture->width, picture->height, 0, GL_BGRA,
                 GL_UNSIGNED_INT_8_8_8_8_REV, picture->pixels);
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_READ_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, display_framebuffer(display));
    bool same = size.width == picture->width && size.height == picture->height;
    glBlitFramebuffer(0, 0, picture->width, picture->height, 0, size.height, size.width, 0,
                      GL_COLOR_BUFFER_BIT, same ? GL_NEAREST : GL_LINEAR);
    display_present(display);
    glDeleteFramebuffers(1, &framebuffer);
    glDeleteTextures(1, &texture);
}

static void show_loading(Display *display, Session *session) {
    while (!session_loaded(session)) {
        draw_bar(display, display_seconds(display));
        display_wait(display, BAR_EVERY);
        // Keys struck before there is a picture are meant for nothing.
        for (DisplayEvent event; display_next_event(display, &event);)
            if (event.kind == DISPLAY_CLOSED) session_event(session, &event);
    }
    const SessionPicture *picture = session_first_picture(session);
    if (picture) show_picture(display, picture);
}

// ---- the loop

static bool draw(Display *display, DisplaySize size, double scale, Session *session, Error *error) {
    if (!session_draw(session, size.width, size.height, scale, error)) return false;
    session_show(session, display_framebuffer(display), size.width, size.height);
    display_present(display);
    return true;
}

static bool run_window(double wanted, Display *display, Session *session, Error *error) {
    while (!session_ended(session)) {
        DisplaySize size = display_size(display);
        bool unseen = size.width < 1 || size.height < 1;
        display_wait(display, session_pause(session, unseen));
        // The time that was slept passes before the events that ended the sleep: a key that was struck now was not held meanwhile.
        session_advance(session, display_seconds(display));
        for (DisplayEvent event; display_next_event(display, &event);) session_event(session, &event);
        session_advance(session, display_seconds(display));
        display_hold_mouse(display, session_wants_mouse(session));
        display_fill_screen(display, session_wants_full_screen(session));
        size = display_size(display);
        double scale = wanted > 0 ? wanted : size.scale;
        if (size.width < 1 || size.height < 1 || !session_changed(session, size.width, size.height, scale))
            continue;
        if (!draw(display, size, scale, session, error)) return false;
    }
    return !session_failed(session, error);
}

// The window that other threads wake, once there is one.
typedef struct Waker {
    _Atomic(Display *) display;
} Waker;

static void wake(void *context) {
    Display *display = atomic_load(&((Waker *)context)->display);
    if (display) display_wake(display);
}

bool walk_window(const SessionOptions *options, const DisplayOptions *window, double scale,
                 const SessionLoader *loader, Arena *arena, Error *error) {
    Waker *waker = ARENA_ARRAY(arena, Waker, 1);
    SessionOptions waking = *options;
    waking.wake = wake;
    waking.wake_context = waker;
    Session *session = session_begin(&waking, loader, window->width, window->height, arena);
    Display *display = display_open(&DISPLAY_GLFW, window, arena, error);
    if (!display) {
        session_free(session);
        return false;
    }
    atomic_store(&waker->display, display);
    show_loading(display, session);
    if (!session_open(session, error)) {
        display_close(display);
        return false;
    }
    bool good = run_window(scale, display, session, error) && session_keep_recording(session, error);
    session_free(session);
    display_close(display);
    return good;
}
