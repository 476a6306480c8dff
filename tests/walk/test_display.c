// test_display.c - events are dependable whatever comes, the off-screen display follows its cues, and a real window under
// a virtual X server delivers keys, mouse and sizes.
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
#include "engine/walk/display_back_end.h"
#include "tests/support/support.h"

// ---- the queue

static void gather_nothing(Display *display) { (void)display; }
static void hold_nothing(Display *display, bool held) { (void)display, (void)held; }
static const DisplayBackEnd NOWHERE = {
    .name = "nowhere", .gather = gather_nothing, .hold_mouse = hold_nothing};

static DisplayEvent random_event(Random *random) {
    static const DisplayEventKind KINDS[] = {
        DISPLAY_KEY_PRESSED,    DISPLAY_KEY_PRESSED,     DISPLAY_KEY_RELEASED,
        DISPLAY_BUTTON_PRESSED, DISPLAY_BUTTON_RELEASED, DISPLAY_LOOK,
        DISPLAY_SCROLLED,       DISPLAY_RESIZED,         DISPLAY_FOCUS_GAINED};
    DisplayEvent event = {.kind = KINDS[random_index(random, sizeof KINDS / sizeof *KINDS)],
                          .x = random_index(random, 100),
                          .y = random_index(random, 100)};
    if (random_unit(random) < 0.02) event.kind = DISPLAY_FOCUS_LOST;
    bool button = event.kind == DISPLAY_BUTTON_PRESSED || event.kind == DISPLAY_BUTTON_RELEASED;
    event.key = button ? DISPLAY_BUTTON_LEFT + random_index(random, 3) : 'A' + random_index(random, 26);
    return event;
}

// Takes what is delivered and keeps count of the keys that are down.
static void take(Display *display, bool *down, int *held, int seed) {
    for (DisplayEvent e; display_next_event(display, &e);) {
        bool press = e.kind == DISPLAY_KEY_PRESSED || e.kind == DISPLAY_BUTTON_PRESSED;
        bool release = e.kind == DISPLAY_KEY_RELEASED || e.kind == DISPLAY_BUTTON_RELEASED;
        if (press || release) {
            cr_assert_eq(down[e.key], release, "seed %d: key %d is %s twice", seed, e.key,
                         press ? "pressed" : "released");
            down[e.key] = press;
            *held += press ? 1 : -1;
        }
        if (e.kind == DISPLAY_FOCUS_LOST)
            cr_assert_eq(*held, 0, "seed %d: %d keys are down without focus", seed, *held);
    }
}

// Whatever comes and however late it is taken: presses and releases of a key take turns, and none is down when the focus
// is lost or all were released.
Test(display, presses_find_their_release) {
    for (int seed = 0; seed < support_count(300, 10000); seed++) {
        Random random = {(uint64_t)seed};
        Display display = {.back_end = &NOWHERE};
        bool down[DISPLAY_KEYS] = {false};
        int held = 0;
        for (int round = 0; round < 10; round++) {
            // More than the queue holds, at times.
            int events = random_index(&random, 3 * DISPLAY_QUEUE);
            display_hold_mouse(&display, random_index(&random, 2));
            for (int i = 0; i < events; i++) display_push(&display, random_event(&random));
            if (random_index(&random, 4) > 0) take(&display, down, &held, seed);
        }
        for (int key = 0; key < DISPLAY_KEYS; key++)
            display_push(&display, (DisplayEvent){.kind = DISPLAY_KEY_RELEASED, .key = key});
        take(&display, down, &held, seed);
        cr_assert_eq(held, 0, "seed %d: %d keys stay down", seed, held);
    }
}

// The mouse's way adds up to one event a frame, and a free mouse looks nowhere.
Test(display, looks_add_up) {
    Display display = {.back_end = &NOWHERE};
    DisplayEvent e;
    display_push(&display, (DisplayEvent){.kind = DISPLAY_LOOK, .x = 1});
    cr_expect(!display_next_event(&display, &e), "a free mouse looks");
    display_hold_mouse(&display, true);
    for (int i = 0; i < 100000; i++)
        display_push(&display, (DisplayEvent){.kind = DISPLAY_LOOK, .x = 1, .y = -2});
    cr_assert(display_next_event(&display, &e));
    cr_expect(e.kind == DISPLAY_LOOK && e.x == 100000 && e.y == -200000, "it looks by %g, %g", e.x, e.y);
    cr_expect(!display_next_event(&display, &e));
}

// ---- off-screen

static Display *open_display(const DisplayBackEnd *back_end, const DisplayOptions *options, Arena *arena) {
    Error error = {""};
    Display *display = display_open(back_end, options, arena, &error);
    cr_assert(display, "%s", error.text);
    return display;
}

static void expect_colour(unsigned framebuffer, int x, int y, const unsigned char rgb[3]) {
    unsigned char found[4];
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glReadPixels(x, y, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, found);
    cr_expect(memcmp(found, rgb, 3) == 0, "pixel %d,%d is %d %d %d", x, y, found[0], found[1], found[2]);
}

static void fill(Display *display, float r, float g, float b) {
    DisplaySize size = display_size(display);
    glBindFramebuffer(GL_FRAMEBUFFER, display_framebuffer(display));
    glViewport(0, 0, size.width, size.height);
    glClearColor(r, g, b, 1);
    glClear(GL_COLOR_BUFFER_BIT);
}

// Cues come when their time has come, a key that was down goes up with the focus, and each present takes a sixtieth.
Test(display, offscreen_follows_its_cues) {
    const DisplayCue cues[] = {{0, {.kind = DISPLAY_KEY_PRESSED, .key = 'W'}},
                               {0.05, {.kind = DISPLAY_KEY_PRESSED, .key = 'W'}},
                               {0.1, {.kind = DISPLAY_FOCUS_LOST}},
                               {0.1, {.kind = DISPLAY_RESIZED, .x = 1, .y = 1}},
                               {0.5, {.kind = DISPLAY_CLOSED}}};
    static const struct {
        int frame;
        DisplayEventKind kind;
    } EXPECTED[] = {{0, DISPLAY_KEY_PRESSED},
                    {6, DISPLAY_KEY_RELEASED},
                    {6, DISPLAY_FOCUS_LOST},
                    {6, DISPLAY_RESIZED},
                    {30, DISPLAY_CLOSED}};
    Arena arena = {0};
    DisplayOptions options = display_default_options();
    options.cues = cues;
    options.cue_count = 5;
    Display *display = open_display(&DISPLAY_OFFSCREEN, &options, &arena);
    int seen = 0;
    for (int frame = 0; frame < 40; frame++) {
        for (DisplayEvent e; display_next_event(display, &e); seen++) {
            cr_assert_lt(seen, 5);
            cr_expect(e.kind == EXPECTED[seen].kind && frame == EXPECTED[seen].frame,
                      "event %d: kind %d in frame %d", seen, e.kind, frame);
        }
        cr_expect_float_eq(display_seconds(display), frame / 60.0, 1e-9);
        display_present(display);
    }
    cr_expect_eq(seen, 5);
    cr_expect_eq(display_size(display).width, 1);
    display_close(display);
    arena_free(&arena);
}

// A frame that is drawn into its framebuffer can be read back, at any size and scale; one display after the other.
Test(display, offscreen_frames) {
    static const DisplayOptions SIZES[] = {{.width = 1, .height = 1, .scale = 1},
                                           {.width = 320, .height = 200, .scale = 2},
                                           {.width = 333, .height = 77, .scale = 1.5}};
    for (int i = 0; i < 3; i++) {
        Arena arena = {0};
        Display *display = open_display(&DISPLAY_OFFSCREEN, &SIZES[i], &arena);
        DisplaySize size = display_size(display);
        cr_expect_eq(size.width, (int)lround(SIZES[i].width * SIZES[i].scale));
        cr_expect_eq(size.height, (int)lround(SIZES[i].height * SIZES[i].scale));
        cr_expect_eq(size.scale, SIZES[i].scale);
        fill(display, 1, 0, 1);
        expect_colour(display_framebuffer(display), size.width - 1, size.height - 1,
                      (unsigned char[]){255, 0, 255});
        cr_expect_eq(glGetError(), GL_NO_ERROR);
        display_close(display);
        arena_free(&arena);
    }
}

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
static bool wait_for(Display *display, DisplayEventKind kind, int key, DisplayEvent *out, int *presses) {
    double end = display_seconds(display) + 5;
    while (display_seconds(display) < end) {
        for (DisplayEvent e; display_next_event(display, &e);) {
            if (presses && e.kind == DISPLAY_KEY_PRESSED && e.key == key) ++*presses;
            if (e.kind != kind || (key >= 0 && e.key != key)) continue;
            *out = e;
            return true;
        }
        fill(display, 0, 1, 0);
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
    Display *display = open_display(&DISPLAY_GLFW, &options, arena);
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
    fill(display, 0, 0, 1);
    expect_colour(display_framebuffer(display), 399, 299, (unsigned char[]){0, 0, 255});
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
    fill(display, 1, 1, 1);
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
