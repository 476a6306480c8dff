// test_light_walk.c - a walk that is lit as one walks.
#include <criterion/criterion.h>
#include <dirent.h>
#include <stdatomic.h>
#include <unistd.h>

#include "engine/scene/light.h"
#include "engine/walk/session_state.h"
#include "tests/support/support.h"
#include "tests/support/walk_loader.h"
#include "tests/walk/light_thread_fixture.h"

// ---- a walk that is lit as one walks

typedef struct Walked {
    Arena arena;
    Display *display;
    Session *session;
    char *folder, *file;
    double now;
} Walked;

static const SessionLoader USUAL = {walk_loader_lit, NULL, NULL};

static void walk_in(Walked *w, const char *building, WalkLook look, const char *cache, SessionLoader loader) {
    Error error;
    *w = (Walked){.arena = {0}};
    w->folder = support_folder(&w->arena);
    setenv("XDG_CACHE_HOME", cache ? cache : w->folder, 1);
    w->file = arena_format(&w->arena, "%s/%s", w->folder, strrchr(building, '/') + 1);
    Bytes bytes = support_read(&w->arena, building);
    cr_assert(file_write(w->file, bytes.data, bytes.size, &error), "%s", error.text);
    DisplayOptions display = display_default_options();
    w->display = display_open(&DISPLAY_OFFSCREEN, &display, &w->arena, &error);
    cr_assert(w->display, "%s", error.text);
    SessionOptions options = session_default_options();
    options.file = w->file;
    options.pictures = w->folder;
    options.look = look;
    w->session = session_new(&options, &loader, &w->arena, &error);
    cr_assert(w->session, "%s", error.text);
}

static void frame(Walked *w) {
    Error error;
    session_advance(w->session, w->now += 1.0 / 60);
    cr_assert(session_draw(w->session, 64, 36, 1, &error), "%s", error.text);
}

// A frame at the pace of a window: frames without a pause would take the bake's core.
static void frame_in_time(Walked *w) {
    frame(w);
    usleep(1000000 / 60);
}

static void leave(Walked *w) {
    session_free(w->session);
    display_close(w->display);
    arena_free(&w->arena);
}

static void walk_until_lit(Walked *w) {
    const LightThread *thread = w->session->shown->baking;
    while (session_light_arriving(w->session) || light_thread_lamps(thread) == LAMPS_SOUGHT) frame_in_time(w);
    for (int i = 0; i < 120; i++) frame(w);
}

static bool same_files(Arena *arena, const char *a, const char *b) {
    Bytes x = support_read(arena, a), y = support_read(arena, b);
    return x.size == y.size && memcmp(x.data, y.data, x.size) == 0;
}

// Proves that a walk without light gets it: the look becomes the baked one by itself, in the end the light is that of
// `enfilade bake --lamps each`, and what is stored is its file, byte for byte.
Test(light_thread, arrives_as_a_bake_of_its_own, .timeout = 300) {
    Walked w;
    char *output;
    walk_in(&w, "build/maps/two-rooms.plan", WALK_LOOKS, NULL, USUAL);
    frame(&w);
    cr_expect_eq(w.session->look, WALK_FAST);
    walk_until_lit(&w);
    cr_expect_eq(w.session->look, WALK_BAKED);
    const LitLight *shown = walk_renderer_lit(w.session->shown->renderer);
    cr_assert(shown);
    int code = support_run(&w.arena, &output,
                           "%s/enfilade bake %s --lamps each -o %s/whole.rad && ls %s/enfilade/*.rad",
                           support_build(), w.file, w.folder, w.folder);
    cr_assert_eq(code, 0, "%s", output);
    output = strstr(output, arena_format(&w.arena, "%s/enfilade/", w.folder));
    output[strcspn(output, "\n")] = '\0';
    cr_expect(same_files(&w.arena, output, arena_format(&w.arena, "%s/whole.rad", w.folder)), "%s differs",
              output);
    // Shown is what a walk that finds the file shows.
    WalkLight light;
    Error error;
    const LoadedScene *scene = w.session->shown->scene.scene;
    cr_assert(light_load(output, scene, &w.arena, &light, &error), "%s", error.text);
    const LitMesh *mesh = lit_mesh_new(light.mesh, &w.arena, &w.arena);
    LitLight loaded = lit_light_new(mesh, &w.arena);
    lit_light_fill(mesh, light.solution, NULL, &loaded);
    cr_expect_arr_eq(shown->vertex, loaded.vertex, (size_t)lit_vertex_count(mesh) * sizeof *loaded.vertex);
    leave(&w);
}

// Proves that light that has no place to be kept arrives all the same, and is not said to be kept.
Test(light_thread, arrives_without_a_cache, .timeout = 300) {
    Walked w;
    walk_in(&w, "build/maps/two-rooms.plan", WALK_LOOKS, "/dev/null", USUAL);
    while (session_light_arriving(w.session)) frame_in_time(&w);
    frame(&w);
    cr_expect(strstr(w.session->message, "no cache to keep it in"), "%s", w.session->message);
    for (int i = 0; i < 120; i++) frame(&w);
    cr_expect_eq(w.session->look, WALK_BAKED);
    cr_expect(session_light_shown(w.session));
    leave(&w);
}

// Proves that who chose a look keeps it while light arrives.
Test(light_thread, a_chosen_look_stays, .timeout = 300) {
    Walked w;
    walk_in(&w, "build/maps/two-rooms.plan", WALK_FAST, NULL, USUAL);
    walk_until_lit(&w);
    cr_expect_eq(w.session->look, WALK_FAST);
    cr_expect(walk_renderer_lit(w.session->shown->renderer));
    leave(&w);
}

// A baker that does not ask whether to stop until it is let go, and the walk that it outlives.
static struct {
    atomic_bool started, let_go, ended;
    void *outlived;
} deaf;

static bool bake_deaf(void *context, const LightHooks *hooks, Arena *arena, WalkLight *out, Error *error) {
    (void)context, (void)hooks, (void)arena, (void)out;
    atomic_store(&deaf.started, true);
    while (!atomic_load(&deaf.let_go)) light_thread_check_nap();
    atomic_store(&deaf.ended, true);
    return error_set(error, "no light today");
}

static bool load_deaf(void *context, const char *path, Arena *arena, WalkScene *out, Error *error) {
    if (!walk_loader_lit(context, path, arena, out, error)) return false;
    out->baker = (LightBaker){.bake = bake_deaf};
    return true;
}

// Proves that whoever leaves a walk waits for no bake: the bake is let go only after the walk has been left.
Test(light_thread, leaving_waits_for_no_bake, .timeout = 60) {
    Walked w;
    walk_in(&w, "build/maps/two-rooms.plan", WALK_FAST, NULL, (SessionLoader){load_deaf, NULL, NULL});
    while (!atomic_load(&deaf.started)) frame(&w);
    deaf.outlived = w.session->shown;  // the bake's until the program ends
    session_free(w.session);
    cr_expect_not(atomic_load(&deaf.ended));
    atomic_store(&deaf.let_go, true);
    while (!atomic_load(&deaf.ended)) light_thread_check_nap();
    w.session = NULL;
    leave(&w);
}

// The bake of a building, whose questions whether to stop are counted. Static, since it may outlive the walk.
enum { LEFT = 7, SPACING = 50, FEWEST_ASKED = 200 };

typedef struct Counted {
    LightBaker baker;
    Progress progress;          // of the walk
    atomic_int asked, ignored;  // ignored: answers to go on after the walk was left
    atomic_bool left;
} Counted;

static Counted counted[LEFT];

static bool count(void *context, const char *stage, double done) {
    Counted *c = context;
    bool left = atomic_load(&c->left), on = progress_report(&c->progress, stage, done);
    if (left && on) atomic_fetch_add(&c->ignored, 1);
    atomic_fetch_add(&c->asked, 1);
    return on;
}

static bool bake_counted(void *context, const LightHooks *hooks, Arena *arena, WalkLight *out, Error *error) {
    Counted *c = context;
    LightHooks own = *hooks;
    c->progress = own.progress;
    own.progress = (Progress){count, c};
    return c->baker.bake(c->baker.context, &own, arena, out, error);
}

static bool load_counted(void *context, const char *path, Arena *arena, WalkScene *out, Error *error) {
    Counted *c = context;
    if (!walk_loader_lit(NULL, path, arena, out, error)) return false;
    c->baker = out->baker;
    out->baker = (LightBaker){bake_counted, c, .keeps = out->baker.keeps};
    return true;
}

// Proves that a walk is left at any time of a bake, from before its first question whether to stop to after its last one; that the
// bake is not told to go on afterwards; and that this leaves no .rad or a whole one. A whole bake asks 356 times, about once a
// shot: with fewer than 200 questions some would be far apart.
Test(light_thread, a_walk_is_left_in_a_bake, .timeout = 300) {
    for (int k = 0; k < LEFT; k += support_count(3, 1)) {
        Walked w;
        char *output;
        Counted *c = &counted[k];
        walk_in(&w, "build/maps/two-rooms.plan", WALK_FAST, NULL, (SessionLoader){load_counted, c, NULL});
        bool whole = k == LEFT - 1;
        while (session_light_arriving(w.session) && (whole || atomic_load(&c->asked) < SPACING * k))
            frame_in_time(&w);
        session_free(w.session);
        atomic_store(&c->left, true);
        w.session = NULL;
        if (whole) cr_expect_geq(atomic_load(&c->asked), FEWEST_ASKED);
        int code =
            support_run(&w.arena, &output,
                        "for rad in %s/enfilade/*.rad; do test ! -e $rad || %s/enfilade walk %s --light $rad "
                        "--size 32x18 --offscreen %s/frames --every 1000 || exit 1; done",
                        w.folder, support_build(), w.file, w.folder);
        cr_expect_eq(code, 0, "%s", output);
        cr_expect_eq(atomic_load(&c->ignored), 0, "it goes on %d times", c->ignored);
        leave(&w);
    }
}

// Proves that a file read again in the middle of a bake is baked anew, as often as that happens, and is lit in the end.
Test(light_thread, a_changed_file_is_baked_anew, .timeout = 300) {
    Walked w;
    Error error;
    walk_in(&w, "build/maps/two-rooms.plan", WALK_LOOKS, NULL, USUAL);
    const char *text = (char *)support_read(&w.arena, w.file).data;
    for (int k = 0; k < 4; k++) {
        for (int i = 0; i < 4 * k; i++) frame(&w);
        text = arena_format(&w.arena, "%s\n# %d\n", text, k);
        cr_assert(file_write(w.file, text, strlen(text), &error), "%s", error.text);
        session_event(w.session, &(DisplayEvent){DISPLAY_KEY_PRESSED, DISPLAY_KEY_F5, 0, 0});
    }
    walk_until_lit(&w);
    cr_expect_eq(light_thread_end(w.session->shown->baking), LIGHT_READY);
    cr_expect(session_light_shown(w.session));
    cr_expect_null(w.session->leaving, "what was shown before is gone");
    leave(&w);
}

typedef struct Watched {
    int asked, most;  // how often; threads of this process
} Watched;

// Breaks off soon.
static bool watch_threads(void *context, const char *stage, double done) {
    Watched *w = context;
    int count = 0;
    (void)stage, (void)done;
    DIR *threads = opendir("/proc/self/task");
    while (readdir(threads)) count++;
    closedir(threads);
    if (count > w->most) w->most = count;
    return ++w->asked < 20;
}

// Proves that a bake takes as many threads as it was given, for its mesh too: in the background of a walk, one core is the walk's.
// Where there is one core nothing can show.
Test(light_thread, takes_no_more_threads_than_given) {
    Arena arena = {0};
    Error error;
    WalkScene scene;
    WalkLight light;
    Watched before = {0}, given = {0};
    setenv("XDG_CACHE_HOME", support_folder(&arena), 1);
    cr_assert(walk_loader_lit(NULL, "build/maps/two-rooms.plan", &arena, &scene, &error), "%s", error.text);
    watch_threads(&before, "", 0);
    LightHooks hooks = {.progress = {watch_threads, &given}, .threads = 1};
    cr_expect_not(scene.baker.bake(scene.baker.context, &hooks, &arena, &light, &error));
    cr_expect_gt(given.asked, 10);
    cr_expect_eq(given.most, before.most, "%d threads more than there were", given.most - before.most);
    arena_free(&arena);
}

// Proves that a building without any light is walked in as ever, and nothing is said.
Test(light_thread, no_lamps_no_light, .timeout = 60) {
    Walked w;
    walk_in(&w, "tests/seeds/room.obj", WALK_LOOKS, NULL, USUAL);
    cr_assert_null(w.session->shown->baking);
    *w.session->message = '\0';
    for (int i = 0; i < 10; i++) frame(&w);
    cr_expect_eq(w.session->look, WALK_FAST);
    cr_expect_str_eq(w.session->message, "");
    leave(&w);
}

// ---- the hour

static void turn(Walked *w, int key, int hours) {
    session_event(w->session, &(DisplayEvent){DISPLAY_KEY_PRESSED, DISPLAY_KEY_LEFT_SHIFT, 0, 0});
    for (int i = 0; i < hours; i++) {
        session_event(w->session, &(DisplayEvent){DISPLAY_KEY_PRESSED, key, 0, 0});
        session_event(w->session, &(DisplayEvent){DISPLAY_KEY_RELEASED, key, 0, 0});
    }
    session_event(w->session, &(DisplayEvent){DISPLAY_KEY_RELEASED, DISPLAY_KEY_LEFT_SHIFT, 0, 0});
}

static void wait_for_hour(Walked *w) {
    while (session_coming_done(w->session) >= 0) frame_in_time(w);
    frame(w);
}

// The light that is shown is that of the usual date and place at an hour.
static void check_sun(const Walked *w, double hour) {
    const LitLight *light = walk_renderer_lit(w->session->shown->renderer);
    SunPosition sun = sun_position(2026, 6, 21, hour, 50 * M_PI / 180, 0);
    cr_assert(light);
    cr_expect_lt(vec3_length(vec3_sub(light->day.sun, sun_direction(&sun, 0))), 1e-9);
}

// A room with a window and a lamp, and another one behind a door: their rows fit in memory.
static const char *hour_plan(Arena *arena) {
    static const char PLAN[] =
        "plan 1\nmaterial m #A0A0A0\nmaterial glow reflectance 0.3 emission 10\nground m height 0\n"
        "storey s floor 0 height 2.5 slab 0.3\n"
        "room first 0,0 4,0 4,3 0,3 floor m ceiling m walls m wall 0.1\n"
        "room second 4.1,0 7.1,0 7.1,3 4.1,3 floor m ceiling m walls m wall 0.1\n"
        "window w 2,-0.05 width 1 height 1 sill 1\n"
        "door d 4.05,1.5 angle 90 width 0.9 height 2 hinge left swing 85 material m\n"
        "inlay glow ceiling 1,1 1.5,1 1.5,1.5 1,1.5\nstart 2,2 yaw 0\n";
    const char *path = arena_format(arena, "%s/hour.plan", support_folder(arena));
    Error error = {""};
    cr_assert(file_write(path, PLAN, sizeof PLAN - 1, &error), "%s", error.text);
    return path;
}

// Proves that the hour turns: the light of another hour comes while the one before is shown, with doors, person and lamps as they are; an
// hour that is turned back before its light has come changes nothing; by night there is no daylight; and the light that is kept for the
// next walk stays that of the hour asked for.
Test(light_thread, hour_is_turned, .timeout = 300) {
    SceneOptions load = scene_default_options();
    Walked w;
    load.lamps = SCENE_LAMPS_ALL;
    load.day.day = load.find_light = load.light_later = true;
    Arena arena = {0};
    walk_in(&w, hour_plan(&arena), WALK_LOOKS, NULL,
            (SessionLoader){walk_scene_load, &load, walk_scene_turn});
    Session *s = w.session;
    // The light of each lamp is still looked for when the hour turns.
    while (session_light_arriving(s)) frame_in_time(&w);
    for (int k = 0; k < 120; k++) frame(&w);
    check_sun(&w, 10);
    const char *kept = light_place(&s->shown->scene.scene->building, &w.arena);
    Bytes before = support_read(&w.arena, kept);
    session_event(s, &(DisplayEvent){DISPLAY_KEY_PRESSED, 'O', 0, 0});
    for (int i = 0; i < 240; i++) frame(&w);
    s->shown->lit[0] = (Rgb){0.5f, 0.5f, 0.5f};
    Vec3 eye = s->person.eye;
    const Shown *shown = s->shown;
    turn(&w, '.', 3);
    turn(&w, ',', 1);
    frame(&w);
    cr_expect_eq(s->shown, shown, "light is shown until other light is there");
    cr_expect_str_eq(s->hour, "12:00");
    wait_for_hour(&w);
    cr_expect_eq(s->shown, shown, "the building is not read again");
    check_sun(&w, 12);
    cr_expect_str_eq(s->message, "12:00");
    cr_expect_eq(s->look, WALK_BAKED);
    cr_expect_lt(vec3_length(vec3_sub(eye, s->person.eye)), 1e-6);
    cr_expect_eq(s->shown->lit[0].r, 0.5f);
    const Building *b = s->shown->scene.graph->building;
    for (int i = 0; i < b->opening_count; i++)
        cr_expect(b->openings[i].leaf_count == 0 || s->shown->doors.open[i] == 1, "door %d is open", i);
    shown = s->shown;
    turn(&w, '.', 1);
    turn(&w, ',', 1);
    wait_for_hour(&w);
    cr_expect_eq(s->shown, shown, "turned back");
    check_sun(&w, 12);
    // Each light takes the place of the one before the last.
    for (int i = 1; i <= 3; i++) {
        turn(&w, '.', 1);
        wait_for_hour(&w);
        check_sun(&w, 12 + i);
    }
    turn(&w, ',', 3);
    wait_for_hour(&w);
    check_sun(&w, 12);
    turn(&w, '.', 13);
    cr_expect_str_eq(s->hour, "01:00, night");
    wait_for_hour(&w);
    cr_expect_not(daylight_shines(&walk_renderer_lit(s->shown->renderer)->day));
    Bytes after = support_read(&w.arena, kept);
    cr_expect(before.size == after.size && memcmp(before.data, after.data, after.size) == 0);
    turn(&w, ',', 15);
    wait_for_hour(&w);
    check_sun(&w, 10);
    leave(&w);
    arena_free(&arena);
}

// Proves that a walk whose hour cannot be turned says why: under an even sky, without a bake, and without a loader that could.
Test(light_thread, hour_that_stays, .timeout = 120) {
    static const struct {
        double sky;
        int lamps;
        bool turns;
        const char *said;
    } CASES[] = {{3, SCENE_LAMPS_ALL, true, "an even sky (--sky) has none"},
                 {0, SCENE_LAMPS_NONE, true, "this walk bakes no light (--no-bake)"},
                 {0, SCENE_LAMPS_ALL, false, "no light is baked"}};
    for (int i = 0; i < 3; i++) {
        SceneOptions load = scene_default_options();
        Walked w;
        load.lamps = CASES[i].lamps;
        load.day.sky[0] = CASES[i].sky;
        walk_in(&w, "build/maps/two-rooms.plan", WALK_LOOKS, NULL,
                (SessionLoader){walk_scene_load, &load, CASES[i].turns ? walk_scene_turn : NULL});
        frame(&w);
        turn(&w, '.', 1);
        cr_expect(strstr(w.session->message, CASES[i].said), "case %d: %s", i, w.session->message);
        cr_expect(session_coming_done(w.session) < 0);
        leave(&w);
    }
}
