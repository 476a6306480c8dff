// test_soak.c - a walk by someone who presses every key, for as long as one likes: twenty minutes under the sanitizers in `make soak`.
#include <criterion/criterion.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "engine/core/clock.h"
#include "engine/core/random.h"
#include "engine/walk/session.h"
#include "engine/walk/session_state.h"
#include "tests/support/support.h"

typedef struct Soak {
    Arena arena;
    SceneOptions load;
    Display *display;
    Session *session;
    char *file;
    Bytes building;
    Random random;
    double now;
    long frames, events, doors, changes, faults;
} Soak;

static int below(Soak *s, int count) { return random_index(&s->random, count); }

// Another file each time, so that all that is derived is made anew: a comment more. Some hold a fault: the walk goes on in what
// it has.
static void change_file(Soak *s) {
    Error error;
    bool fault = below(s, 4) == 0;
    char *tail = arena_format(&s->arena, "\n%s %ld\n", fault ? "nonsense" : "# change", s->changes);
    size_t more = strlen(tail);
    unsigned char *text = malloc(s->building.size + more);
    cr_assert(text);
    memcpy(text, s->building.data, s->building.size);
    memcpy(text + s->building.size, tail, more);
    cr_assert(file_write(s->file, text, s->building.size + more, &error), "%s", error.text);
    free(text);
    s->changes++;
    s->faults += fault;
}

static void strike(Soak *s, int key) {
    session_event(s->session, &(DisplayEvent){DISPLAY_KEY_PRESSED, key, 0, 0});
    session_event(s->session, &(DisplayEvent){DISPLAY_KEY_RELEASED, key, 0, 0});
}

// The next deed of a hand. Everything there is a key for, what leaves the walk or fills the disk apart.
static void do_something(Soak *s) {
    static const char HELD[] = "WASD C", STRUCK[] = "EEEEEOFGGKNBVXTMIU-=0123456789H,.";
    static const int OTHERS[] = {DISPLAY_KEY_PAGE_UP, DISPLAY_KEY_PAGE_DOWN, DISPLAY_KEY_LEFT_SHIFT};
    int press = below(s, 2) ? DISPLAY_KEY_PRESSED : DISPLAY_KEY_RELEASED;
    int key = STRUCK[below(s, sizeof STRUCK - 1)];
    s->events++;
    switch (below(s, 8)) {
    case 0:
    case 1:
    case 2:
        session_event(s->session, &(DisplayEvent){press, HELD[below(s, sizeof HELD - 1)], 0, 0});
        break;
    case 3:
    case 4:
        session_event(s->session,
                      &(DisplayEvent){DISPLAY_LOOK, 0, below(s, 2001) - 1000, below(s, 201) - 100});
        break;
    case 5:
        strike(s, OTHERS[below(s, 3)]);
        break;
    case 6:
        session_event(s->session, &(DisplayEvent){DISPLAY_SCROLLED, 0, 0, below(s, 3) - 1});
        break;
    default:
        strike(s, key);
        s->doors += key == 'E' || key == 'O';
    }
    if (below(s, 300) == 0) change_file(s);
    if (below(s, 300) == 0) strike(s, DISPLAY_KEY_F5);
}

static void begin(Soak *s, const char *building, uint64_t seed) {
    Error error;
    *s = (Soak){.random = {seed}};
    char *folder = support_folder(&s->arena);
    setenv("XDG_CACHE_HOME", folder, 1);
    s->file = arena_format(&s->arena, "%s/%s", folder, strrchr(building, '/') + 1);
    s->building = support_read(&s->arena, building);
    cr_assert(file_write(s->file, s->building.data, s->building.size, &error), "%s", error.text);
    DisplayOptions display = display_default_options();
    s->display = display_open(&DISPLAY_OFFSCREEN, &display, &s->arena, &error);
    cr_assert(s->display, "%s", error.text);
    SessionOptions options = session_default_options();
    options.file = s->file;
    options.pictures = folder;
    s->load = scene_default_options();
    s->load.lamps = SCENE_LAMPS_ALL;
    SessionLoader loader = {walk_scene_load, &s->load, walk_scene_turn};
    s->session = session_new(&options, &loader, &s->arena, &error);
    cr_assert(s->session, "%s", error.text);
}

// Bytes of memory that this process holds.
static double memory(void) {
    long pages = 0, resident = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    cr_assert(file);
    cr_assert_eq(fscanf(file, "%ld %ld", &pages, &resident), 2);
    fclose(file);
    return (double)resident * (double)sysconf(_SC_PAGESIZE);
}

static void frame(Soak *s, uint64_t seed) {
    Error error;
    session_advance(s->session, s->now += 1.0 / 30);
    int width = 32 + below(s, 100), height = 32 + below(s, 60);
    cr_assert(session_draw(s->session, width, height, 1, &error), "seed %llu, frame %ld: %s",
              (unsigned long long)seed, s->frames, error.text);
    Vec3 eye = s->session->person.eye;
    cr_assert(isfinite(eye.x) && isfinite(eye.y) && isfinite(eye.z), "seed %llu, frame %ld: the eye is lost",
              (unsigned long long)seed, s->frames);
    s->frames++;
}

// How much more memory a walk may hold at its end than after a third of it: what the allocator and OpenGL keep in fragments, and
// one building more, as one is freed after the next is there. A leak of a building a reload is ten times as much.
static const double MOST_GROWTH = 96e6;
// Outside a soak, all.
enum { FEWEST_FRAMES = 200 };

// Proves that whatever is pressed the walk goes on, without an error that sanitizers or asserts see, and that its memory stays as it
// is: random walks, doors, looks, stored views, hours, files that change and break meanwhile, bakes in the background broken off and begun.
Test(soak, walks_on_whatever_is_pressed, .timeout = 3600) {
    static const char *const BUILDINGS[] = {"build/maps/two-rooms.plan", "build/maps/house.plan",
                                            "build/maps/office-plain.plan"};
    const char *minutes = getenv("ENFILADE_SOAK_MINUTES");
    double seconds = support_soak() ? 60 * (minutes ? atof(minutes) : 20) : 0;
    int buildings = support_soak() ? 3 : 1;
    for (int b = 0; b < buildings; b++) {
        Soak s;
        uint64_t seed = (uint64_t)(b + 1);
        begin(&s, BUILDINGS[b], seed);
        double start = clock_seconds(), share = seconds / buildings, early = 0, late = 0;
        for (double t = 0; t < share || s.frames < FEWEST_FRAMES; t = clock_seconds() - start) {
            for (int i = below(&s, 4); i > 0; i--) do_something(&s);
            frame(&s, seed);
            double *peak = t < share / 3 ? &early : &late;
            if (s.frames % 16 == 0) *peak = fmax(*peak, memory());
        }
        printf("soak: %s, %ld frames, %ld events, %ld of doors, %ld changed files of which %ld bad, %.0f "
               "then %.0f MB\n",
               BUILDINGS[b], s.frames, s.events, s.doors, s.changes, s.faults, early / 1e6, late / 1e6);
        if (support_soak())
            cr_expect_lt(late, early + MOST_GROWTH, "memory grows: seed %llu", (unsigned long long)seed);
        session_free(s.session);
        display_close(s.display);
        arena_free(&s.arena);
    }
}
