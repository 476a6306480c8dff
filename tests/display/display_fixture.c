// display_fixture.c - see the header.
#include "tests/display/display_fixture.h"

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
#include "tests/support/support.h"

Display *display_check_open_display(const DisplayBackEnd *back_end, const DisplayOptions *options,
                                    Arena *arena) {
    Error error = {""};
    Display *display = display_open(back_end, options, arena, &error);
    cr_assert(display, "%s", error.text);
    return display;
}

void display_check_expect_colour(unsigned framebuffer, int x, int y, const unsigned char rgb[3]) {
    unsigned char found[4];
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glReadPixels(x, y, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, found);
    cr_expect(memcmp(found, rgb, 3) == 0, "pixel %d,%d is %d %d %d", x, y, found[0], found[1], found[2]);
}

void display_check_fill(Display *display, float r, float g, float b) {
    DisplaySize size = display_size(display);
    glBindFramebuffer(GL_FRAMEBUFFER, display_framebuffer(display));
    glViewport(0, 0, size.width, size.height);
    glClearColor(r, g, b, 1);
    glClear(GL_COLOR_BUFFER_BIT);
}
