// session_fixture.h - a walk without a window.
#ifndef TESTS_SESSION_FIXTURE_H
#define TESTS_SESSION_FIXTURE_H

#include "engine/walk/session.h"
#include "engine/walk/session_state.h"
#include "tests/support/support.h"

typedef struct Driven {
    Arena arena;
    Display *display;
    Session *session;
    char *folder, *file;
    double now;
} Driven;

void session_check_begin(Driven *d, const char *building);

void session_check_end(Driven *d);

void session_check_down(Driven *d, int key);

void session_check_up(Driven *d, int key);

void session_check_strike(Driven *d, int key);

void session_check_pass(Driven *d, double seconds);

void session_check_draw(Driven *d, int width, int height);

#endif
