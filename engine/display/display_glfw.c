// display_glfw.c - a window by GLFW 3.3, with a core OpenGL 3.3 context. The scene is drawn elsewhere and copied here, so
// the window's own framebuffer has neither depth nor several samples.
#include <glad/gl.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "engine/display/display_back_end.h"

typedef struct Window {
    GLFWwindow *glfw;
    double x, y;                           // of the mouse when it last moved, in GLFW's screen coordinates
    bool entered;                          // the next place of the mouse is no motion
    int left, top, old_width, old_height;  // where the window was before it filled the screen
} Window;

static Window *own(const Display *display) { return display->own; }

// ---- keys

static const struct {
    int glfw, count, key;  // a run of keys that stand in the same order on both sides
} RUNS[] = {{GLFW_KEY_ESCAPE, 6, DISPLAY_KEY_ESCAPE},  // enter, tab, backspace, insert, delete
            {GLFW_KEY_RIGHT, 8, DISPLAY_KEY_RIGHT},    // left, down, up, page up, page down, home, end
            {GLFW_KEY_F1, 12, DISPLAY_KEY_F1},
            {GLFW_KEY_LEFT_SHIFT, 1, DISPLAY_KEY_LEFT_SHIFT},
            {GLFW_KEY_RIGHT_SHIFT, 1, DISPLAY_KEY_RIGHT_SHIFT},
            {GLFW_KEY_LEFT_CONTROL, 1, DISPLAY_KEY_LEFT_CONTROL},
            {GLFW_KEY_RIGHT_CONTROL, 1, DISPLAY_KEY_RIGHT_CONTROL},
            {GLFW_KEY_LEFT_ALT, 1, DISPLAY_KEY_LEFT_ALT},
            {GLFW_KEY_RIGHT_ALT, 1, DISPLAY_KEY_RIGHT_ALT},
            {GLFW_KEY_KP_0, 10, '0'},
            {GLFW_KEY_KP_DECIMAL, 1, '.'},
            {GLFW_KEY_KP_DIVIDE, 1, '/'},
            {GLFW_KEY_KP_SUBTRACT, 1, '-'},
            {GLFW_KEY_KP_EQUAL, 1, '='},
            {GLFW_KEY_KP_ENTER, 1, DISPLAY_KEY_ENTER}};

// The key's name in display.h; -1 for keys that have no name there.
static int key_of(int glfw) {
    // Printing keys have the same names in GLFW: their ASCII codes on an American keyboard.
    if (glfw >= GLFW_KEY_SPACE && glfw <= GLFW_KEY_GRAVE_ACCENT) return glfw;
    for (size_t i = 0; i < sizeof RUNS / sizeof *RUNS; i++) {
        int place = glfw - RUNS[i].glfw;
        if (place >= 0 && place < RUNS[i].count) return RUNS[i].key + place;
    }
    return -1;
}

static int button_of(int glfw) {
    switch (glfw) {
    case GLFW_MOUSE_BUTTON_LEFT:
        return DISPLAY_BUTTON_LEFT;
    case GLFW_MOUSE_BUTTON_RIGHT:
        return DISPLAY_BUTTON_RIGHT;
    case GLFW_MOUSE_BUTTON_MIDDLE:
        return DISPLAY_BUTTON_MIDDLE;
    default:
        return -1;
    }
}

// ---- GLFW's callbacks

static Display *display_of(GLFWwindow *glfw) { return glfwGetWindowUserPointer(glfw); }

static void on_key(GLFWwindow *glfw, int code, int scancode, int action, int modifiers) {
    (void)scancode, (void)modifiers;
    int key = key_of(code);
    if (key < 0 || action == GLFW_REPEAT) return;
    int kind = action == GLFW_PRESS ? DISPLAY_KEY_PRESSED : DISPLAY_KEY_RELEASED;
    display_push(display_of(glfw), (DisplayEvent){.kind = kind, .key = key});
}

static void on_button(GLFWwindow *glfw, int code, int action, int modifiers) {
    (void)modifiers;
    int button = button_of(code);
    if (button < 0) return;
    int kind = action == GLFW_PRESS ? DISPLAY_BUTTON_PRESSED : DISPLAY_BUTTON_RELEASED;
    display_push(display_of(glfw), (DisplayEvent){.kind = kind, .key = button});
}

static double scale_of(GLFWwindow *glfw) {
    float x, y;
    glfwGetWindowContentScale(glfw, &x, &y);
    return x > 0 ? (double)x : 1;
}

// Points for one screen coordinate: screen coordinates are pixels on some systems and points on others.
static double points(GLFWwindow *glfw) {
    int pixels, wide, high;
    glfwGetFramebufferSize(glfw, &pixels, &high);
    glfwGetWindowSize(glfw, &wide, &high);
    return wide > 0 ? (double)pixels / wide / scale_of(glfw) : 1;
}

static void on_motion(GLFWwindow *glfw, double x, double y) {
    Display *display = display_of(glfw);
    Window *w = own(display);
    double unit = points(glfw);
    if (!w->entered)
        display_push(display,
                     (DisplayEvent){.kind = DISPLAY_LOOK, .x = (x - w->x) * unit, .y = (y - w->y) * unit});
    w->entered = false;
    w->x = x;
    w->y = y;
}

static void on_scroll(GLFWwindow *glfw, double x, double y) {
    display_push(display_of(glfw), (DisplayEvent){.kind = DISPLAY_SCROLLED, .x = x, .y = y});
}

static void on_size(GLFWwindow *glfw, int width, int height) {
    display_push(display_of(glfw), (DisplayEvent){.kind = DISPLAY_RESIZED, .x = width, .y = height});
}

static void on_focus(GLFWwindow *glfw, int focused) {
    Display *display = display_of(glfw);
    Window *w = own(display);
    // While the focus was lost the mouse moved elsewhere: that is no motion here.
    if (focused) glfwGetCursorPos(glfw, &w->x, &w->y);
    display_push(display, (DisplayEvent){.kind = focused ? DISPLAY_FOCUS_GAINED : DISPLAY_FOCUS_LOST});
}

static void on_refresh(GLFWwindow *glfw) {
    display_push(display_of(glfw), (DisplayEvent){.kind = DISPLAY_EXPOSED});
}

// The pointer came in, or the window came under it: where it is now is no motion of the hand.
static void on_enter(GLFWwindow *glfw, int entered) {
    if (entered) own(display_of(glfw))->entered = true;
}

static void on_close(GLFWwindow *glfw) {
    glfwSetWindowShouldClose(glfw, GLFW_FALSE);
    display_push(display_of(glfw), (DisplayEvent){.kind = DISPLAY_CLOSED});
}

static void listen(Display *display) {
    GLFWwindow *glfw = own(display)->glfw;
    glfwSetWindowUserPointer(glfw, display);
    glfwSetKeyCallback(glfw, on_key);
    glfwSetMouseButtonCallback(glfw, on_button);
    glfwSetCursorPosCallback(glfw, on_motion);
    glfwSetScrollCallback(glfw, on_scroll);
    glfwSetFramebufferSizeCallback(glfw, on_size);
    glfwSetWindowFocusCallback(glfw, on_focus);
    glfwSetWindowCloseCallback(glfw, on_close);
    glfwSetWindowRefreshCallback(glfw, on_refresh);
    glfwSetCursorEnterCallback(glfw, on_enter);
}

// ---- open and close

static bool fail(const char *what, Error *error) {
    const char *reason = NULL;
    glfwGetError(&reason);
    return error_set(error, "%s: %s; --offscreen DIR draws without a window", what,
                     reason ? reason : "GLFW gives no reason");
}

static GLFWwindow *create(const DisplayOptions *options) {
    glfwDefaultWindowHints();
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_DEPTH_BITS, 0);
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
    glfwWindowHint(GLFW_ALPHA_BITS, 0);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    glfwWindowHint(GLFW_AUTO_ICONIFY, GLFW_FALSE);
    return glfwCreateWindow(options->width, options->height, options->title, NULL, NULL);
}

static bool open_window(Display *display, const DisplayOptions *options, Arena *arena, Error *error) {
    Window *w = display->own = ARENA_ARRAY(arena, Window, 1);
    if (!glfwInit()) return fail("no window can be opened", error);
    w->glfw = create(options);
    if (!w->glfw) {
        fail("no window with OpenGL 3.3 can be opened", error);
        glfwTerminate();
        return false;
    }
    glfwMakeContextCurrent(w->glfw);
    if (!gladLoadGL((GLADloadfunc)glfwGetProcAddress)) {
        glfwTerminate();
        return error_set(error, "the window's OpenGL lacks functions of version 3.3, which are needed");
    }
    glfwSwapInterval(options->vsync);
    glfwGetCursorPos(w->glfw, &w->x, &w->y);
    listen(display);
    return true;
}

static void close_window(Display *display) {
    glfwDestroyWindow(own(display)->glfw);
    glfwTerminate();
}

// ---- the rest of the table

static DisplaySize glfw_size(const Display *display) {
    DisplaySize size = {.scale = scale_of(own(display)->glfw)};
    glfwGetFramebufferSize(own(display)->glfw, &size.width, &size.height);
    if (glfwGetWindowAttrib(own(display)->glfw, GLFW_ICONIFIED) ||
        !glfwGetWindowAttrib(own(display)->glfw, GLFW_VISIBLE))
        size.width = size.height = 0;
    return size;
}

static unsigned framebuffer_of(const Display *display) {
    (void)display;
    return 0;
}

static void glfw_gather(Display *display) {
    (void)display;
    glfwPollEvents();
}

static void present(Display *display) { glfwSwapBuffers(own(display)->glfw); }

static void glfw_wait(Display *display, double seconds) {
    (void)display;
    if (seconds > 0) glfwWaitEventsTimeout(seconds);
}

static void glfw_wake(Display *display) {
    (void)display;
    glfwPostEmptyEvent();
}

static double seconds_of(const Display *display) {
    (void)display;
    return glfwGetTime();
}

static void hold_mouse(Display *display, bool held) {
    Window *w = own(display);
    glfwSetInputMode(w->glfw, GLFW_CURSOR, held ? GLFW_CURSOR_DISABLED : GLFW_CURSOR_NORMAL);
    // The motion is taken without the desktop's acceleration, where the system can deliver it so.
    if (glfwRawMouseMotionSupported()) glfwSetInputMode(w->glfw, GLFW_RAW_MOUSE_MOTION, held);
    glfwGetCursorPos(w->glfw, &w->x, &w->y);
}

// The screen that holds the middle of the window, so that the window fills the screen it is on.
static GLFWmonitor *screen_of(const Window *w) {
    int count = 0, x = w->left + w->old_width / 2, y = w->top + w->old_height / 2;
    GLFWmonitor **screens = glfwGetMonitors(&count);
    for (int i = 0; i < count; i++) {
        int left, top;
        const GLFWvidmode *mode = glfwGetVideoMode(screens[i]);
        glfwGetMonitorPos(screens[i], &left, &top);
        if (mode && left <= x && x < left + mode->width && top <= y && y < top + mode->height)
            return screens[i];
    }
    return glfwGetPrimaryMonitor();
}

static void fill_screen(Display *display, bool full) {
    Window *w = own(display);
    if (!full) {
        glfwSetWindowMonitor(w->glfw, NULL, w->left, w->top, w->old_width, w->old_height, GLFW_DONT_CARE);
        return;
    }
    glfwGetWindowPos(w->glfw, &w->left, &w->top);
    glfwGetWindowSize(w->glfw, &w->old_width, &w->old_height);
    GLFWmonitor *screen = screen_of(w);
    const GLFWvidmode *mode = screen ? glfwGetVideoMode(screen) : NULL;
    if (mode) glfwSetWindowMonitor(w->glfw, screen, 0, 0, mode->width, mode->height, mode->refreshRate);
}

static void set_title(Display *display, const char *title) { glfwSetWindowTitle(own(display)->glfw, title); }

const DisplayBackEnd DISPLAY_GLFW = {
    "glfw",  "a window, by GLFW", open_window, close_window, glfw_size,  framebuffer_of, glfw_gather,
    present, glfw_wait,           glfw_wake,   seconds_of,   hold_mouse, fill_screen,    set_title};
