// session_idle.c - when a new frame would show anything new, and how long the walk may sleep until it has something to do. What a frame
// shows is compared with what the last frame showed, so that no key or file needs to say that it changed something.
#include <string.h>

#include "engine/walk/session_state.h"

// A sleeping walk looks at its file this often, seconds.
static const double LOOK_AT_FILE = 0.5;
// How often a walk that is recorded, replayed or moved by a held key goes on while its window is not to be seen, seconds.
static const double UNSEEN = 1.0 / 30;
// An eye that went less far has not moved, metres: a hundredth of a millimetre is no pixel.
static const double STAYED = 1e-5;
// Messages and hints fade in so many steps.
static const double FADE_STEPS = 64;

static int steps(double opacity) { return (int)lrint(FADE_STEPS * opacity); }

static SessionSeen take_note(const Session *s, int width, int height, double scale) {
    SessionSeen seen;
    // With its padding, so that two can be compared as bytes.
    memset(&seen, 0, sizeof seen);
    seen.shown = s->shown;
    seen.light = walk_renderer_lit(s->shown->renderer);
    seen.recording = s->recording;
    seen.replay = s->replay;
    seen.width = width;
    seen.height = height;
    seen.scale = scale;
    seen.yaw = s->person.yaw;
    seen.pitch = s->person.pitch;
    seen.fov = s->fov;
    seen.stops = s->exposure.stops;
    bool flags[] = {s->frozen, s->wireframe, s->stab_tree,     s->plan,           s->statistics,
                    s->help,   s->mouse,     s->person.flying, s->exposure.fixed, s->message_is_error,
                    s->lamps};
    for (size_t i = 0; i < sizeof flags / sizeof *flags; i++) seen.flags |= (unsigned)flags[i] << i;
    seen.choices[0] = (int)s->culling;
    seen.choices[1] = (int)s->look;
    seen.choices[2] = (int)s->false_colour;
    seen.message =
        *s->message ? steps(hud_message_opacity(s->now - s->message_since, s->message_is_error)) : 0;
    seen.message_since = seen.message > 0 ? s->message_since : 0;
    seen.hint = steps(session_hint_opacity(s));
    seen.door = session_door(s);
    if (seen.door >= 0) {
        seen.door_wanted = s->shown->doors.wanted[seen.door];
        seen.door_halt = s->shown->doors.halt[seen.door];
    }
    seen.lamp = session_lamp(s);
    seen.lamp_chosen = s->lamp_chosen;
    if (s->statistics) seen.light_done = (int)(100 * (session_light_done(s) + session_coming_done(s)));
    return seen;
}

// Is a picture on its way to another one, or has light come that no frame has taken?
static bool picture_moves(const Session *s) {
    Shown *shown = s->shown;
    if (s->picture_wanted || s->adapting || walk_renderer_fading(shown->renderer)) return true;
    return shown->baking && (session_light_waits(s) || light_thread_end(shown->baking) != shown->told);
}

bool session_changed(Session *s, int width, int height, double scale) {
    const int doors = s->shown->scene.graph->building->opening_count;
    SessionSeen now = take_note(s, width, height, scale);
    s->changed = s->frames == 0 || s->exposed || picture_moves(s) ||
                 memcmp(&now, &s->seen, sizeof now) != 0 ||
                 vec3_length(vec3_sub(s->person.eye, s->seen_eye)) > STAYED ||
                 memcmp(s->shown->drawn_open, s->shown->doors.open, (size_t)doors * sizeof(float)) != 0;
    if (s->changed) return true;
    // Nothing adapts and no frame is late in a time in which none is wanted.
    s->drawn_at = s->now;
    s->last_frame = 0;
    return false;
}

void session_note_seen(Session *s, int width, int height, double scale) {
    const int doors = s->shown->scene.graph->building->opening_count;
    s->seen = take_note(s, width, height, scale);
    s->seen_eye = s->person.eye;
    s->exposed = false;
    s->frames++;
    memcpy(s->shown->drawn_open, s->shown->doors.open, (size_t)doors * sizeof(float));
}

// ---- sleep

static bool walk_goes_on(const Session *s) {
    for (int i = 0; i < HELD_KEYS; i++)
        if (s->held[i] > 0) return true;
    return s->moved || s->replay || s->recording || doors_move(&s->shown->doors);
}

// Until something that is shown from `since` on begins to fade, or fades by another step.
static void until_fade(const Session *s, double since, double shown, double *pause) {
    double left = since + shown - 1 - s->now;
    if (left > -1) *pause = fmin(*pause, fmax(left, 1 / FADE_STEPS));
}

double session_pause(const Session *s, bool unseen) {
    double pause = LOOK_AT_FILE;
    if (walk_goes_on(s)) return unseen || (!s->changed && !s->moved) ? UNSEEN : 0;
    if (s->trace >= 0) pause = fmin(pause, fmax(s->trace_due - s->now, 0));
    if (unseen) return pause;
    if (s->changed) return 0;
    if (*s->message)
        until_fade(s, s->message_since, s->message_is_error ? HUD_ERROR_SECONDS : HUD_MESSAGE_SECONDS,
                   &pause);
    if (session_hint_opacity(s) > 0) until_fade(s, s->began, SESSION_HINT_SECONDS, &pause);
    return pause;
}
