// test_door_state.c - the sentences in which users say where doors stand.
#include <criterion/criterion.h>
#include <string.h>

#include "engine/scene/door_state.h"

static Opening OPENINGS[] = {{.name = "salon", .kind = OPENING_DOOR, .open = 0.25},
                             {.name = "arch", .kind = OPENING_PASSAGE},
                             {.name = "Front door", .kind = OPENING_DOOR},
                             {.name = "salon", .kind = OPENING_DOOR, .open = 1}};
static const Building FOUR = {.openings = OPENINGS, .opening_count = 4};

static bool apply(const char *sentence, float open[4], Error *error) {
    Arena arena = {0};
    memcpy(open, door_state_drawn(&FOUR, &arena), 4 * sizeof *open);
    arena_free(&arena);
    return door_state_apply(&FOUR, sentence, open, error);
}

// Proves that doors are meant by name or all of them, in any case of letters, that parts count from left to right, and that openings
// without a door stay open.
Test(door_state, says_where) {
    static const struct {
        const char *sentence;
        float open[4];
    } CASES[] = {{"", {0.25F, 1, 0, 1}},
                 {"drawn", {0.25F, 1, 0, 1}},
                 {"closed", {0, 1, 0, 0}},
                 {"all=open", {1, 1, 1, 1}},
                 {"closed, SALON = 40%", {0.4F, 1, 0, 0.4F}},
                 {"open,front door=.5,salon=drawn", {0.25F, 1, 0.5F, 1}},
                 {"open, ,closed", {0, 1, 0, 0}},
                 {"0.1,", {0.1F, 1, 0.1F, 0.1F}}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        float open[4];
        Error error = {""};
        cr_assert(apply(CASES[i].sentence, open, &error), "%s: %s", CASES[i].sentence, error.text);
        for (int k = 0; k < 4; k++)
            cr_expect_float_eq(open[k], CASES[i].open[k], 1e-6F, "%s, opening %d: %g", CASES[i].sentence, k,
                               (double)open[k]);
    }
}

// Proves that a bad part gets a sentence that names it and what is allowed.
Test(door_state, bad_parts_are_told) {
    static const struct {
        const char *sentence, *says;
    } CASES[] = {
        {"salon=wide", "`wide` is no state"}, {"salon=", "`` is no state"},
        {"cellar=open", "called `cellar`"},   {"arch=open", "(allowed: all, salon, Front door, salon)"},
        {"salon=1.5", "`1.5` is no state"},   {"salon=-1", "`-1` is no state"},
        {"salon=nan", "`nan` is no state"},   {"salon=0x1", "`0x1` is no state"}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        float open[4];
        Error error = {""};
        cr_expect_not(apply(CASES[i].sentence, open, &error), "%s", CASES[i].sentence);
        cr_expect(strstr(error.text, CASES[i].says), "%s: %s", CASES[i].sentence, error.text);
    }
    char longest[400];
    float open[4];
    Error error = {""};
    memset(longest, 'x', sizeof longest - 1);
    longest[sizeof longest - 1] = 0;
    cr_expect_not(apply(longest, open, &error));
    cr_expect(strstr(error.text, "longer than 255 bytes"), "%s", error.text);
}
