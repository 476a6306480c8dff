// display.h - where frames go to and events come from: a window (GLFW) or memory (OSMesa), behind one small interface.
// One renderer and one session work on both displays and know neither.
#ifndef WALK_DISPLAY_H
#define WALK_DISPLAY_H

#include "engine/core/arena.h"
#include "engine/core/error.h"

// Keys are places on the keyboard, named after the character that an American keyboard prints there: W A S D lie under the hand on
// every layout, and digits need no shift. Capitals, digits, blank and -=[];',./\` are their ASCII codes (also for the
// keypad's keys), other keys have names.
enum {
    DISPLAY_KEY_ESCAPE = 128,
    DISPLAY_KEY_ENTER,
    DISPLAY_KEY_TAB,
    DISPLAY_KEY_BACKSPACE,
    DISPLAY_KEY_INSERT,
    DISPLAY_KEY_DELETE,
    DISPLAY_KEY_RIGHT,
    DISPLAY_KEY_LEFT,
    DISPLAY_KEY_DOWN,
    DISPLAY_KEY_UP,
    DISPLAY_KEY_PAGE_UP,
    DISPLAY_KEY_PAGE_DOWN,
    DISPLAY_KEY_HOME,
    DISPLAY_KEY_END,
    DISPLAY_KEY_LEFT_SHIFT,
    DISPLAY_KEY_RIGHT_SHIFT,
    DISPLAY_KEY_LEFT_CONTROL,
    DISPLAY_KEY_RIGHT_CONTROL,
    DISPLAY_KEY_LEFT_ALT,
    DISPLAY_KEY_RIGHT_ALT,
    DISPLAY_KEY_F1,
    DISPLAY_KEY_F2,
    DISPLAY_KEY_F3,
    DISPLAY_KEY_F4,
    DISPLAY_KEY_F5,
    DISPLAY_KEY_F6,
    DISPLAY_KEY_F7,
    DISPLAY_KEY_F8,
    DISPLAY_KEY_F9,
    DISPLAY_KEY_F10,
    DISPLAY_KEY_F11,
    DISPLAY_KEY_F12,
    DISPLAY_BUTTON_LEFT,
    DISPLAY_BUTTON_RIGHT,
    DISPLAY_BUTTON_MIDDLE,
    DISPLAY_KEYS
};

enum {
    DISPLAY_KEY_PRESSED,   // `key`, once for a press however long it is held
    DISPLAY_KEY_RELEASED,  // `key`, once for each press, also when the focus is lost while the key is down
    DISPLAY_BUTTON_PRESSED,
    DISPLAY_BUTTON_RELEASED,
    DISPLAY_LOOK,      // the mouse went `x` points to the right and `y` down; only while it is held
    DISPLAY_SCROLLED,  // `x`, `y` notches of the wheel; y > 0 away from the hand
    DISPLAY_EXPOSED,   // the window lost its picture: a frame is wanted even if nothing has changed
    DISPLAY_RESIZED,   // the size is now `x` by `y` pixels
    DISPLAY_FOCUS_LOST,
    DISPLAY_FOCUS_GAINED,
    DISPLAY_CLOSED  // somebody wants to close it
};

typedef struct DisplayEvent {
    int kind;
    int key;  // a character, or DISPLAY_KEY_ESCAPE .. DISPLAY_KEYS - 1
    double x, y;
} DisplayEvent;

// An event that an off-screen display delivers once its clock has reached `at`.
typedef struct DisplayCue {
    double at;  // seconds
    DisplayEvent event;
} DisplayCue;

typedef struct DisplayOptions {
    const char *title;
    int width, height;  // points, 1 .. 8192
    bool full_screen;
    bool vsync;              // present waits for the screen: no frame is torn, and none is drawn in vain
    double scale;            // off-screen: pixels to a point; a window takes its screen's scale
    const DisplayCue *cues;  // off-screen: [cue_count] in order of time
    int cue_count;
} DisplayOptions;
DisplayOptions display_default_options(void);

typedef struct DisplaySize {
    int width, height;  // pixels; 0 by 0 while the window is minimised or not mapped
    double scale;       // pixels to a point
} DisplaySize;

typedef struct Display Display;
typedef struct DisplayBackEnd DisplayBackEnd;  // see display_back_end.h

extern const DisplayBackEnd DISPLAY_GLFW, DISPLAY_OFFSCREEN;

// To be called in the thread where the program began, as windows require. The display's OpenGL 3.3 core context is current, with
// functions loaded, until another context is made current. NULL with the reason in `error`.
Display *display_open(const DisplayBackEnd *back_end, const DisplayOptions *options, Arena *arena,
                      Error *error);
void display_close(Display *display);  // also frees what was made in its context; NULL is allowed

DisplaySize display_size(const Display *display);
unsigned display_framebuffer(const Display *display);  // frames drawn into it, upright, are shown
// The next event; false: there is none for now. Call it once a frame until it returns false.
bool display_next_event(Display *display, DisplayEvent *out);
void display_present(Display *display);
// Sleeps until an event comes, display_wake is called, or so many seconds have passed. Off-screen it returns at once.
void display_wait(Display *display, double seconds);
void display_wake(Display *display);  // from any thread
// Seconds since the display was opened. Off-screen, each present takes a sixtieth of a second, so that a walk driven by cues
// comes out the same every time.
double display_seconds(const Display *display);
void display_hold_mouse(Display *display, bool held);  // hides the pointer; its motion has no bounds
void display_fill_screen(Display *display, bool full);
void display_title(Display *display, const char *title);

#endif
