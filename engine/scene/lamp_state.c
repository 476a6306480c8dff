// lamp_state.c - lamps by number, name and room, and how bright and of what colour they are.
#include "engine/scene/lamp_state.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "engine/scene/state_parts.h"

// A state that is being told.
typedef struct Reader {
    const Lamps *lamps;
    Rgb *lit;
    const char *place;
} Reader;

// ---- states

static bool bad_state(const Reader *r, const char *state, Error *error) {
    return error_set(error,
                     "%s: `%s` is no state of a lamp (allowed: on, off, a share of 0 to %d, a share as 40%%, "
                     "a colour #rrggbb, or a share and a colour as 0.5#ffd8a8)",
                     r->place, state, LAMP_STATE_MOST);
}

static bool read_colour(const char *text, Rgb *out) {
    char *end;
    if (strlen(text) != 7 || !isxdigit((unsigned char)text[1])) return false;
    unsigned long rgb = strtoul(text + 1, &end, 16);
    if (*end) return false;
    *out = maps_colour((unsigned)rgb);
    return out->r + out->g + out->b > 0;
}

typedef struct State {
    float share;
    bool coloured;
    Rgb colour;
} State;

static bool read_state(const Reader *r, const char *text, State *out, Error *error) {
    *out = (State){.share = 1};
    if (strcasecmp(text, "on") == 0) return true;
    if (strcasecmp(text, "off") == 0) {
        out->share = 0;
        return true;
    }
    const char *colour = strchr(text, '#');
    char *end;
    if (colour) {
        out->coloured = true;
        if (!read_colour(colour, &out->colour)) return bad_state(r, text, error);
        if (colour == text) return true;
    }
    if (!isdigit((unsigned char)*text) && *text != '.') return bad_state(r, text, error);
    double share = strtod(text, &end);
    if (*end == '%') share /= 100, end++;
    if ((*end && end != colour) || !(share >= 0 && share <= LAMP_STATE_MOST))
        return bad_state(r, text, error);
    out->share = (float)share;
    return true;
}

// A lamp that is coloured has the hue of the colour, and its flux; a lamp without flux in a channel cannot get any there: the others
// take it.
static Rgb lit_of(const Lamp *lamp, const State *state) {
    if (!state->coloured) return (Rgb){state->share, state->share, state->share};
    double hue[3], all = rgb_sum(lamp->flux), sum = 0, share[3];
    rgb_doubles(state->colour, hue);
    for (int c = 0; c < 3; c++) sum += lamp->flux[c] > 0 ? hue[c] : 0;
    for (int c = 0; c < 3; c++)
        share[c] =
            lamp->flux[c] > 0 && sum > 0 ? (double)state->share * all * hue[c] / sum / lamp->flux[c] : 0;
    return (Rgb){(float)share[0], (float)share[1], (float)share[2]};
}

// ---- lamps

static bool is_meant(const Lamps *lamps, int lamp, const char *who) {
    char *end;
    unsigned long number = strtoul(who, &end, 10);
    if (strcasecmp(who, "all") == 0 || strcasecmp(who, lamps->lamps[lamp].name) == 0 ||
        (*lamps->lamps[lamp].room && strcasecmp(who, lamps->lamps[lamp].room) == 0))
        return true;
    return isdigit((unsigned char)*who) && *end == 0 && number == (unsigned long)lamp + 1;
}

static bool nobody_meant(const Reader *r, const char *who, Error *error) {
    char names[400] = "";
    size_t at = 0;
    for (int i = 0; i < r->lamps->count && at + 80 < sizeof names; i++)
        at += (size_t)snprintf(names + at, sizeof names - at, "%s%.60s", i > 0 ? ", " : "",
                               r->lamps->lamps[i].name);
    if (r->lamps->count == 0)
        return error_set(error, "%s: the building has no lamp that could be switched", r->place);
    return error_set(
        error, "%s: no lamp and no room is called `%s` (allowed: 1 to %d, all, a room, or a lamp: %s%s)",
        r->place, who, r->lamps->count, names, at + 80 < sizeof names ? "" : ", ...");
}

static bool apply_part(void *context, const char *place, const char *who, const char *text, Error *error) {
    Reader *r = context;
    State state;
    bool met = false;
    r->place = place;
    if (!read_state(r, text, &state, error)) return false;
    for (int i = 0; i < r->lamps->count; i++) {
        if (!is_meant(r->lamps, i, who)) continue;
        met = true;
        r->lit[i] = lit_of(&r->lamps->lamps[i], &state);
    }
    return met || nobody_meant(r, who, error);
}

bool lamp_state_apply(const Lamps *lamps, const char *sentence, Rgb *lit, Error *error) {
    Reader r = {.lamps = lamps, .lit = lit};
    return state_parts_apply("--lamps", sentence, apply_part, &r, error);
}

void lamp_state_describe(const Lamps *lamps, int lamp, Rgb lit, char *out, size_t size) {
    double flux[3], share[3], all = rgb_sum(lamps->lamps[lamp].flux);
    rgb_doubles(lit, share);
    for (int c = 0; c < 3; c++) flux[c] = lamps->lamps[lamp].flux[c] * share[c];
    if (share[0] == share[1] && share[1] == share[2]) {
        if (share[0] == 0 || share[0] == 1)
            snprintf(out, size, "%s", share[0] > 0 ? "on" : "off");
        else
            snprintf(out, size, "%.3g%%", 100 * share[0]);
        return;
    }
    snprintf(out, size, "%.3g%% coloured", all > 0 ? 100 * rgb_sum(flux) / all : 0);
}
