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
#include "engine/display/display_back_end.h"
#include "tests/display/display_fixture.h"
#include "tests/support/support.h"

// ---- the queue

static void gather_nothing(Display *display) { (void)display; }

static void hold_nothing(Display *display, bool held) { (void)display, (void)held; }

static const DisplayBackEnd NOWHERE = {
    .name = "nowhere", .gather = gather_nothing, .hold_mouse = hold_nothing};

static DisplayEvent random_event(Random *random) {
    static const int KINDS[] = {DISPLAY_KEY_PRESSED,    DISPLAY_KEY_PRESSED,     DISPLAY_KEY_RELEASED,
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

// Cues come when their time has come, a key that was down goes up with the focus, and each present takes a sixtieth.
Test(display, offscreen_follows_its_cues) {
    const DisplayCue cues[] = {{0, {.kind = DISPLAY_KEY_PRESSED, .key = 'W'}},
                               {0.05, {.kind = DISPLAY_KEY_PRESSED, .key = 'W'}},
                               {0.1, {.kind = DISPLAY_FOCUS_LOST}},
                               {0.1, {.kind = DISPLAY_RESIZED, .x = 1, .y = 1}},
                               {0.5, {.kind = DISPLAY_CLOSED}}};
    static const struct {
        int frame;
        int kind;
    } EXPECTED[] = {{0, DISPLAY_KEY_PRESSED},
                    {6, DISPLAY_KEY_RELEASED},
                    {6, DISPLAY_FOCUS_LOST},
                    {6, DISPLAY_RESIZED},
                    {30, DISPLAY_CLOSED}};
    Arena arena = {0};
    DisplayOptions options = display_default_options();
    options.cues = cues;
    options.cue_count = 5;
    Display *display = display_check_open_display(&DISPLAY_OFFSCREEN, &options, &arena);
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
        Display *display = display_check_open_display(&DISPLAY_OFFSCREEN, &SIZES[i], &arena);
        DisplaySize size = display_size(display);
        cr_expect_eq(size.width, (int)lround(SIZES[i].width * SIZES[i].scale));
        cr_expect_eq(size.height, (int)lround(SIZES[i].height * SIZES[i].scale));
        cr_expect_eq(size.scale, SIZES[i].scale);
        display_check_fill(display, 1, 0, 1);
        display_check_expect_colour(display_framebuffer(display), size.width - 1, size.height - 1,
                                    (unsigned char[]){255, 0, 255});
        cr_expect_eq(glGetError(), GL_NO_ERROR);
        display_close(display);
        arena_free(&arena);
    }
}
