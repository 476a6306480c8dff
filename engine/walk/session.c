// session.c - the start, the end and the ticks of a walk, and reading its file again.
#include <unistd.h>

#include "engine/gl/gl_context.h"
#include "engine/walk/session_state.h"

// If a window stood still for longer than this, seconds, the walk goes on for this time only.
static const double LONGEST_STALL = 0.25;
// Keys turn the head at this speed, radians a second.
static const double TURN = 1.8;
// How long the end of a walk may take, seconds.
static const double LEAVE_SECONDS = 0.01;

SessionOptions session_default_options(void) {
    return (SessionOptions){.pictures = ".", .doors = WALK_DOORS, .culling = CULL_STAB, .look = WALK_LOOKS};
}

// The best look that OpenGL draws in time: in software the fine look takes a tenth of a second.
static WalkLook usual_look(void) { return gl_is_software() ? WALK_FAST : WALK_FINE; }

static bool open_session(Session *s, Error *error) {
    Shown *shown = s->load ? session_load_end(s->load, error) : shown_load(s, error);
    s->load = NULL;
    if (!shown || !shown_upload(s, shown, error)) return false;
    s->shown = shown;
    s->sketched = usual_look();
    if (!s->look_chosen) s->look = s->sketched;
    if (s->shown->scene.light && !s->look_chosen) s->look = WALK_BAKED;
    s->overlay = overlay_new(s->arena, error);
    if (!s->overlay) return false;
    if (!session_open_trace(s, error)) return false;
    session_start(s);
    if (s->options.view && !session_jump_to(s, s->options.view, error)) return false;
    return !s->options.replay || session_follow(s, s->options.replay, error);
}

Session *session_begin(const SessionOptions *options, const SessionLoader *loader, int width, int height,
                       Arena *arena) {
    Session *s = ARENA_ARRAY(arena, Session, 1);
    *s = (Session){.options = *options,
                   .loader = *loader,
                   .arena = arena,
                   .person = {.cell = -1},
                   .fov = FIRST_VIEW_FOV,
                   .culling = options->culling,
                   .false_colour = options->false_colour,
                   .plan = true,
                   .full_screen = options->full_screen,
                   .now = -1,
                   .began = -1,
                   .leave_asked = -INFINITY,
                   .trace = -1,
                   .watch = file_watch_begin(options->file)};
    s->look_chosen = options->look != WALK_LOOKS;
    s->look = options->look;
    s->load = session_load_begin(s, width, height, arena);
    return s;
}

bool session_open(Session *s, Error *error) {
    if (open_session(s, error)) return true;
    session_free(s);
    return false;
}

Session *session_new(const SessionOptions *options, const SessionLoader *loader, Arena *arena, Error *error) {
    Session *s = session_begin(options, loader, 0, 0, arena);
    return session_open(s, error) ? s : NULL;
}

void session_free(Session *s) {
    if (!s) return;
    Error ignored;
    if (s->load) s->shown = session_load_end(s->load, &ignored);
    session_drop_coming(s);
    if (s->recording) session_record(s);
    if (s->trace >= 0) close(s->trace);
    overlay_free(s->overlay);
    // A bake that does not stop at once ends with the program; until then it keeps the data that it uses.
    if (!shown_free(s->shown, LEAVE_SECONDS)) light_thread_abandon(s->shown->baking);
    session_let_go(s);
    for (Shown *shown = s->leaving; shown; shown = shown->next) light_thread_abandon(shown->baking);
    arena_free(&s->recording_arena);
    arena_free(&s->replay_arena);
    arena_free(&s->frame_arena);
}

// ---- reading again

void session_reload(Session *s) {
    Error error;
    // The watch begins anew before the file is read, so that a change read by F5 is not read once more.
    s->watch = file_watch_begin(s->options.file);
    session_drop_coming(s);
    Shown *next = shown_load(s, &error);
    if (!next || !shown_upload(s, next, &error)) {
        session_say(s, true, "%s", error.text);
        return;
    }
    // A recorded path names the doors of the file as it was before.
    s->replay = NULL;
    if (s->recording) session_record(s);
    session_show_next(s, next);
    if (s->look == WALK_BAKED && !next->scene.light && !s->look_chosen) s->look = s->sketched;
    session_say(s, false, "%s was read again", s->options.file);
}

static void watch_file(Session *s) {
    switch (file_watch_look(&s->watch, s->now)) {
    case FILE_CHANGED:
        session_reload(s);
        break;
    case FILE_GONE:
        session_say(s, true, "%s is gone; what was read of it is still shown", s->options.file);
        break;
    default:
        break;
    }
}

// ---- time

static double held(const Session *s, int more, int less) { return (s->held[more] > 0) - (s->held[less] > 0); }

// A person in a fall or a turn, or one that still glides, moves; less than a hundredth of a millimetre a second is none.
static bool person_moved(const Session *s, const Person *before) {
    const double least = 1e-5 / SESSION_TICKS;
    return vec3_length(vec3_sub(s->person.eye, before->eye)) > least || s->person.yaw != before->yaw;
}

static void tick(Session *s) {
    const double seconds = 1.0 / SESSION_TICKS;
    Shown *shown = s->shown;
    s->tick++;
    if (session_replay_tick(s)) return;
    PersonWish wish = {.forward = held(s, HELD_FORWARD, HELD_BACK),
                       .right = held(s, HELD_RIGHT, HELD_LEFT),
                       .up = held(s, HELD_UP, HELD_DOWN),
                       .hurry = s->held[HELD_HURRY] > 0};
    const Person before = s->person;
    person_look(&s->person, TURN * seconds * held(s, HELD_TURN_LEFT, HELD_TURN_RIGHT), 0);
    person_tick(&s->person, &shown->world, &wish, seconds);
    doors_advance(&shown->doors, seconds, s->person.flying ? NULL : &s->person.body);
    s->moved = person_moved(s, &before);
    session_record_tick(s);
}

void session_advance(Session *s, double now) {
    if (s->now < 0) s->now = s->message_since = now;
    double passed = now - s->now;
    s->now = now;
    s->behind += fmin(fmax(passed, 0), LONGEST_STALL);
    for (; s->behind >= 1.0 / SESSION_TICKS; s->behind -= 1.0 / SESSION_TICKS) tick(s);
    watch_file(s);
    session_take_coming(s);
    session_take_turned(s);
    session_let_go(s);
    session_trace(s);
}

bool session_wants_mouse(const Session *s) { return s->mouse; }
bool session_wants_full_screen(const Session *s) { return s->full_screen; }
bool session_ended(const Session *s) { return s->ended; }
bool session_failed(const Session *s, Error *error) {
    return s->failed && !error_set(error, "%s", s->message);
}
