// display_back_end.h - what a back end of the display provides, and where it puts its events. For back ends only.
//
// A back end is one file.
#ifndef WALK_DISPLAY_BACK_END_H
#define WALK_DISPLAY_BACK_END_H

#include "engine/walk/display.h"

struct DisplayBackEnd {
    const char *name, *summary;
    // With `display->own` set, its context current and OpenGL loaded. After a failure nothing is left to close.
    bool (*open)(Display *display, const DisplayOptions *options, Arena *arena, Error *error);
    void (*close)(Display *display);
    DisplaySize (*size)(const Display *display);
    unsigned (*framebuffer)(const Display *display);
    void (*gather)(Display *display);  // gives display_push what has happened
    void (*present)(Display *display);
    double (*seconds)(const Display *display);
    // Called when it changes only.
    void (*hold_mouse)(Display *display, bool held);
    void (*fill_screen)(Display *display, bool full);
    void (*title)(Display *display, const char *title);
};

// Events of one frame: a mouse that reports a thousand times a second makes one, keys come a few at a time. So that each
// press that is delivered finds its release, the last DISPLAY_KEYS places are kept for releases.
#define DISPLAY_QUEUE (4 * DISPLAY_KEYS)

struct Display {
    const DisplayBackEnd *back_end;
    void *own;  // of the back end
    DisplayEvent queue[DISPLAY_QUEUE];
    int first, count;
    bool gathered, mouse_held, full_screen;
    bool down[DISPLAY_KEYS];  // pressed and not yet released, as delivered
};

// Queues an event, if it tells anything new: a press of what is down already, a release of what is not and a look with
// the mouse free do not. With the focus all keys are let go.
void display_push(Display *display, DisplayEvent event);

#endif
