// walk_window.c - the loop: events go in, time goes on, a frame comes out.
#include "engine/walk/walk_window.h"

static bool draw(double wanted, Display *display, Session *session, Error *error) {
    DisplaySize size = display_size(display);
    if (size.width > 0 && size.height > 0) {
        double scale = wanted > 0 ? wanted : size.scale;
        if (!session_draw(session, size.width, size.height, scale, error)) return false;
        session_show(session, display_framebuffer(display), size.width, size.height);
    }
    display_present(display);
    return true;
}

static bool run_window(double scale, Display *display, Session *session, Error *error) {
    while (!session_ended(session)) {
        for (DisplayEvent event; display_next_event(display, &event);) session_event(session, &event);
        session_advance(session, display_seconds(display));
        display_hold_mouse(display, session_wants_mouse(session));
        display_fill_screen(display, session_wants_full_screen(session));
        if (!draw(scale, display, session, error)) return false;
    }
    return true;
}

bool walk_window(const SessionOptions *options, const DisplayOptions *window, double scale,
                 const SessionLoader *loader, Arena *arena, Error *error) {
    Display *display = display_open(&DISPLAY_GLFW, window, arena, error);
    if (!display) return false;
    Session *session = session_new(options, loader, arena, error);
    bool good =
        session && run_window(scale, display, session, error) && session_keep_recording(session, error);
    session_free(session);
    display_close(display);
    return good;
}
