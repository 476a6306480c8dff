// session_fixture.c - see the header.
#include "tests/walk/session_fixture.h"

#include <criterion/criterion.h>

#include "engine/walk/session.h"
#include "maps/maps.h"
#include "tests/support/support.h"

typedef struct Loaded {
    Building building;
    CellGraph graph;
    StabForest forest;
} Loaded;

static bool load(void *context, const char *path, Arena *arena, WalkScene *out, Error *error) {
    (void)context;
    Loaded *l = ARENA_ARRAY(arena, Loaded, 1);
    VisOptions options = vis_default_options();
    if (!maps_read(path, arena, &l->building, error)) return false;
    if (!vis_build_cells(&l->building, &options, arena, &l->graph, error)) return false;
    if (!vis_build_forest(&l->graph, &options, NULL, arena, &l->forest)) return false;
    *out = (WalkScene){.graph = &l->graph, .forest = &l->forest};
    return true;
}

void session_check_begin(Driven *d, const char *building) {
    Error error;
    *d = (Driven){.arena = {0}};
    d->folder = support_folder(&d->arena);
    d->file = arena_format(&d->arena, "%s/%s", d->folder, strrchr(building, '/') + 1);
    Bytes bytes = support_read(&d->arena, building);
    cr_assert(file_write(d->file, bytes.data, bytes.size, &error), "%s", error.text);
    DisplayOptions display = display_default_options();
    d->display = display_open(&DISPLAY_OFFSCREEN, &display, &d->arena, &error);
    cr_assert(d->display, "%s", error.text);
    SessionOptions options = session_default_options();
    options.file = d->file;
    options.pictures = d->folder;
    SessionLoader loader = {load, NULL, NULL};
    d->session = session_new(&options, &loader, &d->arena, &error);
    cr_assert(d->session, "%s", error.text);
    session_advance(d->session, d->now);
}

void session_check_end(Driven *d) {
    session_free(d->session);
    display_close(d->display);
    arena_free(&d->arena);
}

void session_check_down(Driven *d, int key) {
    session_event(d->session, &(DisplayEvent){DISPLAY_KEY_PRESSED, key, 0, 0});
}

void session_check_up(Driven *d, int key) {
    session_event(d->session, &(DisplayEvent){DISPLAY_KEY_RELEASED, key, 0, 0});
}

void session_check_strike(Driven *d, int key) {
    session_check_down(d, key);
    session_check_up(d, key);
}

void session_check_pass(Driven *d, double seconds) {
    for (double until = d->now + seconds; d->now < until;) session_advance(d->session, d->now += 1.0 / 60);
}

void session_check_draw(Driven *d, int width, int height) {
    Error error;
    cr_assert(session_draw(d->session, width, height, 1, &error), "%d x %d: %s", width, height, error.text);
}
