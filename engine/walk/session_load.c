// session_load.c - a building is read in a thread of its own while the window opens, and the first picture is drawn there. At another hour
// it is read and lit in the background of the walk.
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <string.h>

#include "engine/walk/session_state.h"

struct SessionLoad {
    const Session *session;
    pthread_t handle;
    Shown *shown;  // NULL: it could not be read
    Error error;
    SessionPicture picture;
    Arena arena;  // of the picture
    atomic_bool done;
};

static const Viewpoint *named_view(const Session *s, const Building *b) {
    for (int i = 0; s->options.view && i < b->viewpoint_count; i++)
        if (strcmp(b->viewpoints[i].name, s->options.view) == 0) return &b->viewpoints[i];
    return NULL;
}

static void draw_first(SessionLoad *load) {
    const Session *s = load->session;
    Shown *shown = load->shown;
    SessionPicture *p = &load->picture;
    const Viewpoint *from = named_view(s, shown->scene.graph->building);
    if (!from) from = &shown->first;
    Arena scratch = {0};
    FirstScene scene = shown_first_scene(shown);
    Camera camera = camera_look(from->eye, from->yaw, from->pitch, s->fov, p->width, p->height);
    uint32_t *pixels = arena_alloc(&load->arena, (size_t)p->width * (size_t)p->height, sizeof *pixels);
    if (first_picture(&scene, &camera, &scratch, pixels, NULL)) p->pixels = pixels;
    arena_free(&scratch);
}

static void *read_building_in_thread(void *context) {
    SessionLoad *load = context;
    const Session *s = load->session;
    load->shown = shown_load(s, &load->error);
    if (load->shown && load->picture.width > 0) draw_first(load);
    atomic_store(&load->done, true);
    if (s->options.wake) s->options.wake(s->options.wake_context);
    return NULL;
}

SessionLoad *session_load_begin(const Session *s, int width, int height, Arena *arena) {
    SessionLoad *load = ARENA_ARRAY(arena, SessionLoad, 1);
    load->session = s;
    load->picture = (SessionPicture){NULL, width, height};
    return pthread_create(&load->handle, NULL, read_building_in_thread, load) == 0 ? load : NULL;
}

bool session_loaded(const Session *s) { return !s->load || atomic_load(&s->load->done); }

const SessionPicture *session_first_picture(const Session *s) {
    return s->load && atomic_load(&s->load->done) && s->load->picture.pixels ? &s->load->picture : NULL;
}

Shown *session_load_end(SessionLoad *load, Error *error) {
    pthread_join(load->handle, NULL);
    arena_free(&load->arena);
    if (!load->shown) *error = load->error;
    return load->shown;
}

// ---- another hour

// Says the hour, and its day.
static bool turn(Session *s, int minutes, Daylight *day, Error *error) {
    if (!s->loader.turn) return error_set(error, "the hour stays as it is: no light is baked");
    return s->loader.turn(s->loader.context, &s->shown->scene, minutes, s->hour, sizeof s->hour, day, error);
}

void session_drop_coming(Session *s) {
    Error ignored;
    if (s->coming_load) s->coming = session_load_end(s->coming_load, &ignored);
    if (s->coming) session_leave(s, s->coming);
    s->coming_load = NULL;
    s->coming = NULL;
}

// Nothing comes: the hour is that of the building that is shown.
static void stay(Session *s, const char *reason) {
    Error ignored;
    Daylight day;
    session_say(s, true, "%s", reason);
    session_drop_coming(s);
    s->turned = s->shown->turned;
    turn(s, s->turned, &day, &ignored);
}

// The light that is shown goes on to another day, where it can.
static bool follow_hour(Session *s, const Daylight *day) {
    Shown *shown = s->shown;
    if (!shown->baking || !shown->lit || !daylight_shines(day) ||
        light_thread_end(shown->baking) != LIGHT_READY || !light_thread_turns(shown->baking))
        return false;
    shown->turning = true;
    shown->turning_to = s->turned;
    shown->turning_day = *day;
    session_ask_light(shown);
    return true;
}

static void read_at_hour(Session *s) {
    s->coming_load = session_load_begin(s, 0, 0, s->arena);
    if (s->coming_load)
        session_say(s, false, "%s: the light of that hour is on its way", s->hour);
    else
        stay(s, "the hour stays as it is: no thread can be started");
}

void session_take_turned(Session *s) {
    Shown *shown = s->shown;
    const LitLight *light = walk_renderer_lit(shown->renderer);
    if (!shown->turning) return;
    if (light && memcmp(&light->day, &shown->turning_day, sizeof light->day) == 0) {
        shown->turning = false;
        shown->turned = shown->turning_to;
        if (s->turned == shown->turned) session_say(s, false, "%s", s->hour);
    } else if (!light_thread_turns(shown->baking) && !light_thread_behind(shown->baking)) {
        shown->turning = false;
        if (s->turned != shown->turned && !s->coming && !s->coming_load) read_at_hour(s);
    }
}

void session_turn_hour(Session *s, int minutes) {
    Error error;
    Daylight day;
    session_drop_coming(s);
    if (!turn(s, s->turned + minutes, &day, &error)) {
        session_say(s, false, "%s", error.text);
        return;
    }
    s->turned += minutes;
    if (s->turned == s->shown->turned && !s->shown->turning)
        session_say(s, false, "%s", s->hour);
    else if (follow_hour(s, &day))
        session_say(s, false, "%s: its light is on its way", s->hour);
    else
        read_at_hour(s);
}

// Lamps that were switched stay so, where they are the same.
static void keep_lamps(const Shown *before, Shown *next) {
    const LoadedScene *a = before->scene.scene, *b = next->scene.scene;
    if (!a || !b || !next->baking || a->lamps.count != b->lamps.count) return;
    size_t bytes = (size_t)a->lamps.count * sizeof *next->lit;
    if (memcmp(before->lit, next->lit, bytes) == 0) return;
    memcpy(next->lit, before->lit, bytes);
    session_ask_light(next);
}

static void upload_coming(Session *s) {
    Error error;
    Shown *next = session_load_end(s->coming_load, &error);
    s->coming_load = NULL;
    if (!next || !shown_upload(s, next, &error)) {
        stay(s, error.text);
        return;
    }
    s->coming = next;
    if (!next->baking && !next->scene.light) stay(s, "the hour stays as it is: nothing emits light then");
}

void session_take_coming(Session *s) {
    if (s->coming_load && atomic_load(&s->coming_load->done)) upload_coming(s);
    Shown *next = s->coming;
    if (!next) return;
    int end = next->baking ? light_thread_end(next->baking) : LIGHT_READY;
    if (next->baking && !next->scene.baker.parts) {
        walk_renderer_fade(next->renderer, INFINITY);
        shown_receive_light(next, SIZE_MAX);
        if (end == LIGHT_UNDER_WAY || light_thread_light(next->baking)) return;
    }
    if (end == LIGHT_FAILED) {
        stay(s, light_thread_note(next->baking));
        return;
    }
    keep_lamps(s->shown, next);
    s->coming = NULL;
    next->told = end;
    session_show_next(s, next);
    if (walk_renderer_lit(next->renderer) && !s->look_chosen) s->look = WALK_BAKED;
    session_say(s, false, "%s", s->hour);
}
