// display_back_end.h - the functions that a back end of the display provides, and the queue for its events. For back ends only.
//
// A back end is one file.
#ifndef WALK_DISPLAY_BACK_END_H
#define WALK_DISPLAY_BACK_END_H

#include "engine/display/display.h"

struct DisplayBackEnd {
    const char *name, *summary;
    // Sets `display->own`, makes its context current and loads OpenGL. After a failure nothing is left to close.
    bool (*open)(Display *display, const DisplayOptions *options, Arena *arena, Error *error);
    void (*close)(Display *display);
    DisplaySize (*size)(const Display *display);
    unsigned (*framebuffer)(const Display *display);
    void (*gather)(Display *display);  // passes the events that have happened to display_push
    void (*present)(Display *display);
    void (*wait)(Display *display, double seconds);
    void (*wake)(Display *display);
    double (*seconds)(const Display *display);
    // Called only when the value changes.
    void (*hold_mouse)(Display *display, bool held);
    void (*fill_screen)(Display *display, bool full);
    void (*title)(Display *display, const char *title);
};

// The events of one frame: motion of the mouse adds up to one event even if it is reported a thousand times a second, and few keys are
// pressed in a frame. The last DISPLAY_KEYS places are kept for releases, so that each press that is delivered finds its release.
#define DISPLAY_QUEUE (4 * DISPLAY_KEYS)

struct Display {
    const DisplayBackEnd *back_end;
    void *own;  // the back end's data
    DisplayEvent queue[DISPLAY_QUEUE];
    int first, count;
    bool gathered, mouse_held, full_screen;
    bool down[DISPLAY_KEYS];  // pressed and not yet released, as pushed
};

// Queues an event unless it tells nothing new: a press of a key that is down, a release of a key that is up, or a look while the mouse
// is not held. When the focus is lost, all keys are released.
void display_push(Display *display, DisplayEvent event);

#endif
