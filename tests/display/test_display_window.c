// test_display_window.c - a real window: frames, keys, mouse, sizes.
#include <criterion/criterion.h>
#include <glad/gl.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "engine/core/random.h"
#include "engine/display/display_back_end.h"
#include "tests/display/display_fixture.h"
#include "tests/support/support.h"

// ---- a window

// Without a display there is one sentence with the reason and the way out; and the next attempt is a new one.
Test(display, no_display) {
    Arena arena = {0};
    unsetenv("DISPLAY");
    unsetenv("WAYLAND_DISPLAY");
    DisplayOptions options = display_default_options();
    for (int i = 0; i < 2; i++) {
        Error error = {""};
        cr_assert_null(display_open(&DISPLAY_GLFW, &options, &arena, &error));
        cr_expect(strstr(error.text, "no window can be opened: ") && strstr(error.text, "DISPLAY") &&
                      strstr(error.text, "--offscreen DIR"),
                  "%s", error.text);
    }
    arena_free(&arena);
}

static pid_t x_server;

static void stop_x_server(void) {
    kill(x_server, SIGTERM);
    waitpid(x_server, NULL, 0);
}

// `told` is written to once it serves. No two tests have the same number: each is a process of its own.
static _Noreturn void become_x_server(const char *name, int told) {
    char number[16];
    snprintf(number, sizeof number, "%d", told);
    prctl(PR_SET_PDEATHSIG, SIGTERM);  // however the test ends
    execlp("Xvfb", "Xvfb", name, "-displayfd", number, "-screen", "0", "800x600x24", "-nolisten", "tcp",
           NULL);
    _exit(127);
}

// Starts a virtual X server that ends with the test; DISPLAY names it. Skips the test where there is none.
static void start_x_server(void) {
    Arena arena = {0};
    if (support_run(&arena, NULL, "command -v Xvfb && command -v xdotool") != 0)
        cr_skip_test("Xvfb or xdotool is not installed");
    arena_free(&arena);
    char name[16], told;
    int ends[2];
    snprintf(name, sizeof name, ":%d", 1000 + getpid() % 50000);
    cr_assert_eq(pipe(ends), 0);
    x_server = fork();
    cr_assert_geq(x_server, 0);
    if (x_server == 0) become_x_server(name, ends[1]);
    atexit(stop_x_server);
    close(ends[1]);
    if (read(ends[0], &told, 1) != 1) cr_skip_test("Xvfb does not start");
    setenv("DISPLAY", name, 1);
    unsetenv("WAYLAND_DISPLAY");
}

static void type(const char *commands) {
    Arena arena = {0};
    char *output;
    int status = support_run(&arena, &output, "xdotool %s", commands);
    cr_assert_eq(status, 0, "xdotool %s: %s", commands, output);
    arena_free(&arena);
}

// Frames until `kind` has come with `key` (-1: any), for at most five seconds. Counts the presses of `key` on the way.
static bool wait_for(Display *display, int kind, int key, DisplayEvent *out, int *presses) {
    double end = display_seconds(display) + 5;
    while (display_seconds(display) < end) {
        for (DisplayEvent e; display_next_event(display, &e);) {
            if (presses && e.kind == DISPLAY_KEY_PRESSED && e.key == key) ++*presses;
            if (e.kind != kind || (key >= 0 && e.key != key)) continue;
            *out = e;
            return true;
        }
        display_check_fill(display, 0, 1, 0);
        display_present(display);
        usleep(5000);
    }
    return false;
}

// Opens a window of 400 x 300 that has the focus.
static Display *open_window(Arena *arena) {
    DisplayOptions options = display_default_options();
    options.title = "a window";
    options.width = 400;
    options.height = 300;
    options.vsync = false;
    Display *display = display_check_open_display(&DISPLAY_GLFW, &options, arena);
    DisplayEvent e;
    wait_for(display, DISPLAY_FOCUS_GAINED, -1, &e, NULL);
    return display;
}

// The window's framebuffer holds the frame that was drawn; a picture of the window is for the eyes of the walk test.
Test(display, window_shows_frames, .timeout = 60) {
    start_x_server();
    Arena arena = {0};
    Display *display = open_window(&arena);
    DisplaySize size = display_size(display);
    cr_expect(size.width == 400 && size.height == 300 && size.scale == 1, "it is %d x %d, scale %g",
              size.width, size.height, size.scale);
    display_check_fill(display, 0, 0, 1);
    display_check_expect_colour(display_framebuffer(display), 399, 299, (unsigned char[]){0, 0, 255});
    display_title(display, "another title");
    display_present(display);
    cr_expect_eq(glGetError(), GL_NO_ERROR);
    display_close(display);
    arena_free(&arena);
}

// A key that is held, and repeated by the server, is pressed once; it goes up when it is let go, or with the focus.
Test(display, window_keys, .timeout = 60) {
    start_x_server();
    Arena arena = {0};
    Display *display = open_window(&arena);
    DisplayEvent e;
    int presses = 0;
    type("keydown w sleep 1.2 keyup w");
    cr_expect(wait_for(display, DISPLAY_KEY_RELEASED, 'W', &e, &presses), "W does not go up");
    cr_expect_eq(presses, 1, "W goes down %d times", presses);
    type("key F1 key Page_Up key shift key KP_3 key 7");
    cr_expect(wait_for(display, DISPLAY_KEY_PRESSED, DISPLAY_KEY_F1, &e, NULL), "no F1");
    cr_expect(wait_for(display, DISPLAY_KEY_PRESSED, DISPLAY_KEY_PAGE_UP, &e, NULL), "no page up");
    cr_expect(wait_for(display, DISPLAY_KEY_PRESSED, DISPLAY_KEY_LEFT_SHIFT, &e, NULL), "no shift");
    cr_expect(wait_for(display, DISPLAY_KEY_PRESSED, '3', &e, NULL), "no 3 of the keypad");
    cr_expect(wait_for(display, DISPLAY_KEY_PRESSED, '7', &e, NULL), "no 7");
    type("keydown d");
    cr_expect(wait_for(display, DISPLAY_KEY_PRESSED, 'D', &e, NULL), "no D");
    type("search --name 'a window' windowunmap");
    cr_expect(wait_for(display, DISPLAY_KEY_RELEASED, 'D', &e, NULL), "D stays down without focus");
    cr_expect(wait_for(display, DISPLAY_FOCUS_LOST, -1, &e, NULL), "the focus is not lost");
    display_close(display);
    arena_free(&arena);
}

// The way of the mouse in the next half second.
static void look_around(Display *display, double *x, double *y) {
    *x = *y = 0;
    for (double end = display_seconds(display) + 0.5; display_seconds(display) < end; usleep(5000)) {
        for (DisplayEvent e; display_next_event(display, &e);) {
            if (e.kind != DISPLAY_LOOK) continue;
            *x += e.x;
            *y += e.y;
        }
        display_present(display);
    }
}

// The held mouse looks as far as it is moved, beyond all edges of the screen; then the wheel, and the buttons.
Test(display, window_mouse, .timeout = 60) {
    start_x_server();
    Arena arena = {0};
    Display *display = open_window(&arena);
    DisplayEvent e;
    display_hold_mouse(display, true);
    double x, y;
    look_around(display, &x, &y);
    type("mousemove_relative -- 300 -200 mousemove_relative -- 300 -200 mousemove_relative -- 300 -200 "
         "mousemove_relative -- 300 -200 mousemove_relative -- 300 -200");
    look_around(display, &x, &y);
    cr_expect(x == 1500 && y == -1000, "it looks by %g, %g", x, y);
    type("click 4 click 1");
    cr_expect(wait_for(display, DISPLAY_SCROLLED, -1, &e, NULL) && e.y == 1, "the wheel");
    cr_expect(wait_for(display, DISPLAY_BUTTON_PRESSED, DISPLAY_BUTTON_LEFT, &e, NULL), "the button");
    display_hold_mouse(display, false);
    display_close(display);
    arena_free(&arena);
}

static void expect_size(Display *display, int width, int height) {
    DisplayEvent e = {0};
    for (int i = 0; i < 10 && !(e.x == width && e.y == height); i++)
        if (!wait_for(display, DISPLAY_RESIZED, -1, &e, NULL)) break;
    DisplaySize size = display_size(display);
    cr_expect(e.x == width && e.y == height, "told of %g x %g instead of %d x %d", e.x, e.y, width, height);
    cr_expect(size.width == width && size.height == height, "%d x %d instead of %d x %d", size.width,
              size.height, width, height);
    display_check_fill(display, 1, 1, 1);
    display_present(display);
    cr_expect_eq(glGetError(), GL_NO_ERROR);
}

// Down to a single pixel and back, then over the whole screen and back.
Test(display, window_sizes, .timeout = 60) {
    start_x_server();
    Arena arena = {0};
    Display *display = open_window(&arena);
    type("search --name 'a window' windowsize 1 1");
    expect_size(display, 1, 1);
    type("search --name 'a window' windowsize 500 400");
    expect_size(display, 500, 400);
    display_fill_screen(display, true);
    expect_size(display, 800, 600);
    display_fill_screen(display, false);
    expect_size(display, 500, 400);
    display_close(display);
    arena_free(&arena);
}
