// display_fixture.h - events of a display.
#ifndef TESTS_DISPLAY_FIXTURE_H
#define TESTS_DISPLAY_FIXTURE_H

#include "engine/display/display_back_end.h"
#include "tests/support/support.h"

Display *display_check_open_display(const DisplayBackEnd *back_end, const DisplayOptions *options,
                                    Arena *arena);

void display_check_expect_colour(unsigned framebuffer, int x, int y, const unsigned char rgb[3]);

void display_check_fill(Display *display, float r, float g, float b);

#endif
