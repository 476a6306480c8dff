// test_lamp_state.c - the sentences in which users say which lamps are on.
#include <criterion/criterion.h>
#include <stdio.h>
#include <string.h>

#include "engine/scene/lamp_state.h"
#include "tests/support/support.h"

static Lamp LAMPS[] = {{.name = "Pendant", .room = "Kitchen", .flux = {3, 3, 3}},
                       {.name = "Desk lamp", .room = "Study", .flux = {6, 3, 0}},
                       {.name = "Pendant", .room = "Study", .flux = {1, 1, 1}}};
static const Lamps THREE = {.lamps = LAMPS, .count = 3};

static bool apply(const char *sentence, Rgb lit[3], Error *error) {
    for (int i = 0; i < 3; i++) lit[i] = (Rgb){1, 1, 1};
    return lamp_state_apply(&THREE, sentence, lit, error);
}

// Proves that lamps are meant by number, name, room and all of them, in any case of letters, and that parts count from left to right.
Test(lamp_state, says_who) {
    static const struct {
        const char *sentence;
        float share[3];
    } CASES[] = {{"", {1, 1, 1}},
                 {"off", {0, 0, 0}},
                 {"all=off,2=on", {0, 1, 0}},
                 {"pendant=off", {0, 1, 0}},
                 {"STUDY = 40%", {1, 0.4f, 0.4f}},
                 {"Study=off, desk lamp=.25", {1, 0.25f, 0}},
                 {"0.5,1=10", {10, 0.5f, 0.5f}},
                 {"on,,3=0", {1, 1, 0}}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Rgb lit[3];
        Error error = {""};
        cr_assert(apply(CASES[i].sentence, lit, &error), "%s: %s", CASES[i].sentence, error.text);
        for (int k = 0; k < 3; k++)
            cr_expect_float_eq(lit[k].r, CASES[i].share[k], 1e-6f, "%s, lamp %d: %g", CASES[i].sentence,
                               k + 1, (double)lit[k].r);
    }
}

// Proves that a colour keeps the flux of all channels together, times the share, and gives nothing to a channel that a lamp does not have.
Test(lamp_state, colours_keep_the_flux) {
    Rgb lit[3];
    Error error = {""};
    cr_assert(apply("all=50%#ff8000", lit, &error), "%s", error.text);
    for (int i = 0; i < 3; i++) {
        double share[3], flux = 0;
        rgb_doubles(lit[i], share);
        for (int c = 0; c < 3; c++) flux += share[c] * LAMPS[i].flux[c];
        // States are floats.
        cr_expect_float_eq(flux, 0.5 * rgb_sum(LAMPS[i].flux), 1e-6 * flux);
        cr_expect_eq(lit[i].b, 0);
    }
    cr_expect_eq(lit[1].b, 0);
    char words[48];
    lamp_state_describe(&THREE, 0, lit[0], words, sizeof words);
    cr_expect_str_eq(words, "50% coloured");
    lamp_state_describe(&THREE, 0, (Rgb){0, 0, 0}, words, sizeof words);
    cr_expect_str_eq(words, "off");
}

// Proves that a sentence that cannot be meant is refused with the place, what was found and what is allowed.
Test(lamp_state, refuses) {
    static const struct {
        const char *sentence, *says;
    } CASES[] = {{"Kitchn=on",
                  "no lamp and no room is called `Kitchn` (allowed: 1 to 3, all, a room, or a lamp: Pendant"},
                 {"4=on", "no lamp and no room is called `4`"},
                 {"0=on", "no lamp and no room is called `0`"},
                 {"1=maybe", "`maybe` is no state of a lamp"},
                 {"1=-1", "`-1` is no state"},
                 {"1=11", "`11` is no state"},
                 {"1=nan", "`nan` is no state"},
                 {"1=#12345", "`#12345` is no state"},
                 {"1=#12345g", "`#12345g` is no state"},
                 {"1=#000000", "`#000000` is no state"},
                 {"1=0.5 0.6", "`0.5 0.6` is no state"},
                 {"1=", "`` is no state"},
                 {"@/nowhere/lamps", "/nowhere/lamps"}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        Rgb lit[3];
        Error error = {""};
        cr_assert_not(apply(CASES[i].sentence, lit, &error), "%s was taken", CASES[i].sentence);
        cr_expect_not_null(strstr(error.text, CASES[i].says), "%s: %s", CASES[i].sentence, error.text);
    }
    char longest[400];
    memset(longest, 'x', sizeof longest - 1);
    longest[sizeof longest - 1] = 0;
    Rgb lit[3];
    Error error;
    cr_assert_not(apply(longest, lit, &error));
    cr_expect_not_null(strstr(error.text, "is longer than 255 bytes"), "%s", error.text);
}

// Proves that a file holds one part a line, with remarks, and that its faults are told by their line.
Test(lamp_state, reads_files) {
    Arena arena = {0};
    const char *path = arena_format(&arena, "%s/lamps.txt", support_folder(&arena));
    Rgb lit[3];
    Error error = {""};
    for (int bad = 0; bad < 2; bad++) {
        FILE *file = fopen(path, "w");
        cr_assert(file);
        fprintf(file, "# the evening\noff\n\nDesk lamp=70%%\r\n%s", bad ? "Hall=on\n" : "1=off");
        cr_assert_eq(fclose(file), 0);
        bool good = apply(arena_format(&arena, "@%s", path), lit, &error);
        cr_assert_eq(good, !bad, "%s", error.text);
    }
    cr_expect_not_null(strstr(error.text, "lamps.txt:5: no lamp and no room is called `Hall`"), "%s",
                       error.text);
    cr_expect_float_eq(lit[1].r, 0.7f, 1e-6f);
    cr_expect_eq(lit[0].r, 0);
    arena_free(&arena);
}
