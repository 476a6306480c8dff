// session_load.c - a building is read in a thread of its own while the window opens, and the first picture is drawn there.
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

Shown *session_load_end(Session *s, Error *error) {
    SessionLoad *load = s->load;
    pthread_join(load->handle, NULL);
    arena_free(&load->arena);
    s->load = NULL;
    if (!load->shown) *error = load->error;
    return load->shown;
}
