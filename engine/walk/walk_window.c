// walk_window.c - the loop: events go in, time goes on, and a frame comes out where it would show anything new. Else the loop sleeps.
#include "engine/walk/walk_window.h"

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
    return true;
}

static void wake(void *display) { display_wake(display); }

bool walk_window(const SessionOptions *options, const DisplayOptions *window, double scale,
                 const SessionLoader *loader, Arena *arena, Error *error) {
    Display *display = display_open(&DISPLAY_GLFW, window, arena, error);
    if (!display) return false;
    SessionOptions waking = *options;
    waking.wake = wake;
    waking.wake_context = display;
    Session *session = session_new(&waking, loader, arena, error);
    bool good =
        session && run_window(scale, display, session, error) && session_keep_recording(session, error);
    session_free(session);
    display_close(display);
    return good;
}
