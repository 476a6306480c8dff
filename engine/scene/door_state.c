// door_state.c - the language of the doors' states: WHO=STATE parts, applied one after the other.
#include "engine/scene/door_state.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

// The longest part, bytes.
enum { LONGEST = 256 };

float *door_state_drawn(const Building *b, Arena *arena) {
    float *open = ARENA_ARRAY(arena, float, b->opening_count + 1);
    for (int i = 0; i < b->opening_count; i++) {
        const Opening *o = &b->openings[i];
        open[i] = o->kind == OPENING_DOOR ? (float)o->open : 1;
    }
    return open;
}

// The share of its way that a door is to be open; below 0: as drawn.
static bool read_share(const char *state, double *out, Error *error) {
    static const struct {
        const char *word;
        double share;
    } WORDS[] = {{"open", 1}, {"closed", 0}, {"drawn", -1}};
    for (int i = 0; i < 3; i++) {
        if (strcasecmp(state, WORDS[i].word) != 0) continue;
        *out = WORDS[i].share;
        return true;
    }
    char *end = NULL;
    *out = isdigit((unsigned char)*state) || *state == '.' ? strtod(state, &end) : -1;
    bool decimal = end && (size_t)(end - state) == strspn(state, "0123456789.");
    if (end && *end == '%') *out /= 100, end++;
    if (decimal && !*end && *out >= 0 && *out <= 1) return true;
    return error_set(
        error,
        "--doors: `%s` is no state of a door (allowed: open, closed, drawn, a share of 0 to 1, or "
        "a share as 40%%)",
        state);
}

static bool no_door_meant(const Building *b, const char *who, Error *error) {
    char names[400] = "";
    size_t at = 0;
    for (int i = 0; i < b->opening_count && at + 80 < sizeof names; i++)
        if (b->openings[i].kind == OPENING_DOOR)
            at += (size_t)snprintf(names + at, sizeof names - at, "%s%.60s", at > 0 ? ", " : "",
                                   b->openings[i].name);
    return error_set(error, "--doors: no door is called `%s` (allowed: all%s%s%s)", who, *names ? ", " : "",
                     names, at + 80 < sizeof names ? "" : ", ...");
}

static bool apply_to(const Building *b, const char *who, const char *state, float *open, Error *error) {
    bool all = strcasecmp(who, "all") == 0, met = all;
    double share;
    if (!read_share(state, &share, error)) return false;
    for (int i = 0; i < b->opening_count; i++) {
        const Opening *o = &b->openings[i];
        if (o->kind != OPENING_DOOR || (!all && (!o->name || strcasecmp(who, o->name) != 0))) continue;
        open[i] = (float)(share < 0 ? o->open : share);
        met = true;
    }
    return met || no_door_meant(b, who, error);
}

// A word without the spaces around it.
static void take_word(const char *from, size_t length, char out[LONGEST]) {
    while (length > 0 && isspace((unsigned char)*from)) from++, length--;
    while (length > 0 && isspace((unsigned char)from[length - 1])) length--;
    memcpy(out, from, length);
    out[length] = 0;
}

bool door_state_apply(const Building *b, const char *sentence, float *open, Error *error) {
    for (const char *from = sentence; *from;) {
        size_t length = strcspn(from, ","), before = length;
        char who[LONGEST] = "all", state[LONGEST];
        if (length >= LONGEST)
            return error_set(error, "--doors: `%.40s...` is longer than %d bytes", from, LONGEST - 1);
        while (before > 0 && from[before] != '=') before--;
        if (before > 0) take_word(from, before, who);
        take_word(from + (before > 0 ? before + 1 : 0), length - (before > 0 ? before + 1 : 0), state);
        bool blank = before == 0 && *state == 0;
        if (!blank && !apply_to(b, who, state, open, error)) return false;
        from += length + (from[length] == ',');
    }
    return true;
}
