// door_state.c - doors by name, and how far they are open.
#include "engine/scene/door_state.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "engine/scene/state_parts.h"

float *door_state_drawn(const Building *b, Arena *arena) {
    float *open = ARENA_ARRAY(arena, float, b->opening_count + 1);
    for (int i = 0; i < b->opening_count; i++) {
        const Opening *o = &b->openings[i];
        open[i] = o->kind == OPENING_DOOR ? (float)o->open : 1;
    }
    return open;
}

// The share of its way that a door is to be open; below 0: as drawn.
static bool read_share(const char *place, const char *state, double *out, Error *error) {
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
    return error_set(error,
                     "%s: `%s` is no state of a door (allowed: open, closed, drawn, a share of 0 to 1, or "
                     "a share as 40%%)",
                     place, state);
}

static bool no_door_meant(const Building *b, const char *place, const char *who, Error *error) {
    char names[400] = "";
    size_t at = 0;
    for (int i = 0; i < b->opening_count && at + 80 < sizeof names; i++)
        if (b->openings[i].kind == OPENING_DOOR)
            at += (size_t)snprintf(names + at, sizeof names - at, "%s%.60s", at > 0 ? ", " : "",
                                   b->openings[i].name);
    return error_set(error, "%s: no door is called `%s` (allowed: all%s%s%s)", place, who, *names ? ", " : "",
                     names, at + 80 < sizeof names ? "" : ", ...");
}

typedef struct Reader {
    const Building *building;
    float *open;
} Reader;

static bool apply_part(void *context, const char *place, const char *who, const char *state, Error *error) {
    const Reader *r = context;
    const Building *b = r->building;
    bool all = strcasecmp(who, "all") == 0, met = all;
    double share;
    if (!read_share(place, state, &share, error)) return false;
    for (int i = 0; i < b->opening_count; i++) {
        const Opening *o = &b->openings[i];
        if (o->kind != OPENING_DOOR || (!all && (!o->name || strcasecmp(who, o->name) != 0))) continue;
        r->open[i] = (float)(share < 0 ? o->open : share);
        met = true;
    }
    return met || no_door_meant(b, place, who, error);
}

bool door_state_apply(const Building *b, const char *sentence, float *open, Error *error) {
    Reader r = {b, open};
    return state_parts_apply("--doors", sentence, apply_part, &r, error);
}
