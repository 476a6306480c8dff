// display.c - calls of the back end, and the queue that makes their events dependable: presses and releases pair up.
#include "engine/display/display.h"

#include "engine/display/display_back_end.h"

DisplayOptions display_default_options(void) {
    return (DisplayOptions){.title = "Enfilade", .width = 1280, .height = 720, .vsync = true, .scale = 1};
}

// ---- events

static void append(Display *display, DisplayEvent event, int places) {
    if (display->count >= places) return;
    display->queue[(display->first + display->count++) % DISPLAY_QUEUE] = event;
}

static void release(Display *display, int key) {
    if (!display->down[key]) return;
    display->down[key] = false;
    bool button = key >= DISPLAY_BUTTON_LEFT;
    append(display,
           (DisplayEvent){.kind = button ? DISPLAY_BUTTON_RELEASED : DISPLAY_KEY_RELEASED, .key = key},
           DISPLAY_QUEUE);
}

static void press(Display *display, DisplayEvent event) {
    if (display->down[event.key] || display->count >= DISPLAY_QUEUE - DISPLAY_KEYS) return;
    display->down[event.key] = true;
    append(display, event, DISPLAY_QUEUE);
}

// Motion adds up in one event: only the sum matters.
static void look_around(Display *display, DisplayEvent event) {
    if (!display->mouse_held) return;
    DisplayEvent *last =
        &display->queue[(display->first + display->count + DISPLAY_QUEUE - 1) % DISPLAY_QUEUE];
    if (display->count > 0 && last->kind == DISPLAY_LOOK) {
        last->x += event.x;
        last->y += event.y;
    } else {
        append(display, event, DISPLAY_QUEUE - DISPLAY_KEYS);
    }
}

void display_push(Display *display, DisplayEvent event) {
    switch (event.kind) {
    case DISPLAY_KEY_PRESSED:
    case DISPLAY_BUTTON_PRESSED:
        press(display, event);
        break;
    case DISPLAY_KEY_RELEASED:
    case DISPLAY_BUTTON_RELEASED:
        release(display, event.key);
        break;
    case DISPLAY_LOOK:
        look_around(display, event);
        break;
    case DISPLAY_FOCUS_LOST:
        for (int key = 0; key < DISPLAY_KEYS; key++) release(display, key);
        append(display, event, DISPLAY_QUEUE - DISPLAY_KEYS);
        break;
    default:
        append(display, event, DISPLAY_QUEUE - DISPLAY_KEYS);
        break;
    }
}

bool display_next_event(Display *display, DisplayEvent *out) {
    if (display->count == 0 && !display->gathered) {
        display->back_end->gather(display);
        display->gathered = true;
    }
    if (display->count == 0) {
        display->gathered = false;
        return false;
    }
    *out = display->queue[display->first];
    display->first = (display->first + 1) % DISPLAY_QUEUE;
    display->count--;
    return true;
}

// ---- to the back end

Display *display_open(const DisplayBackEnd *back_end, const DisplayOptions *options, Arena *arena,
                      Error *error) {
    CORE_ASSERT(options->width >= 1 && options->height >= 1 && options->scale > 0);
    Display *display = ARENA_ARRAY(arena, Display, 1);
    display->back_end = back_end;
    if (!back_end->open(display, options, arena, error)) return NULL;
    display_fill_screen(display, options->full_screen);
    return display;
}

void display_close(Display *display) {
    if (display) display->back_end->close(display);
}

DisplaySize display_size(const Display *display) { return display->back_end->size(display); }
unsigned display_framebuffer(const Display *display) { return display->back_end->framebuffer(display); }
void display_present(Display *display) { display->back_end->present(display); }
void display_wait(Display *display, double seconds) {
    // Events that are there already come first.
    if (display->count == 0) display->back_end->wait(display, seconds);
}
void display_wake(Display *display) { display->back_end->wake(display); }
double display_seconds(const Display *display) { return display->back_end->seconds(display); }
void display_title(Display *display, const char *title) { display->back_end->title(display, title); }

void display_hold_mouse(Display *display, bool held) {
    if (held == display->mouse_held) return;
    display->mouse_held = held;
    display->back_end->hold_mouse(display, held);
}

void display_fill_screen(Display *display, bool full) {
    if (full == display->full_screen) return;
    display->full_screen = full;
    display->back_end->fill_screen(display, full);
}
