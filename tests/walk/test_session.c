// A walk as its user drives it, without a window: keys and the mouse go in, frames and files come out.
#include <criterion/criterion.h>
#include <unistd.h>

#include "engine/draw/image.h"
#include "engine/walk/session.h"
#include "engine/walk/session_state.h"
#include "maps/maps.h"
#include "tests/support/support.h"

typedef struct Driven {
    Arena arena;
    Display *display;
    Session *session;
    char *folder, *file;
    double now;
} Driven;

typedef struct Loaded {
    Building building;
    CellGraph graph;
    StabForest forest;
} Loaded;

static bool load(void *context, const char *path, Arena *arena, WalkScene *out, Error *error) {
    (void)context;
    Loaded *l = ARENA_ARRAY(arena, Loaded, 1);
    VisOptions options = vis_default_options();
    if (!maps_read(path, arena, &l->building, error)) return false;
    if (!vis_build_cells(&l->building, &options, arena, &l->graph, error)) return false;
    if (!vis_build_forest(&l->graph, &options, NULL, arena, &l->forest)) return false;
    *out = (WalkScene){.graph = &l->graph, .forest = &l->forest};
    return true;
}

static void begin(Driven *d, const char *building) {
    Error error;
    *d = (Driven){.arena = {0}};
    d->folder = support_folder(&d->arena);
    d->file = arena_format(&d->arena, "%s/%s", d->folder, strrchr(building, '/') + 1);
    Bytes bytes = support_read(&d->arena, building);
    cr_assert(file_write(d->file, bytes.data, bytes.size, &error), "%s", error.text);
    DisplayOptions display = display_default_options();
    d->display = display_open(&DISPLAY_OFFSCREEN, &display, &d->arena, &error);
    cr_assert(d->display, "%s", error.text);
    SessionOptions options = session_default_options();
    options.file = d->file;
    options.pictures = d->folder;
    SessionLoader loader = {load, NULL};
    d->session = session_new(&options, &loader, &d->arena, &error);
    cr_assert(d->session, "%s", error.text);
    session_advance(d->session, d->now);
}

static void end(Driven *d) {
    session_free(d->session);
    display_close(d->display);
    arena_free(&d->arena);
}

static void down(Driven *d, int key) {
    session_event(d->session, &(DisplayEvent){DISPLAY_KEY_PRESSED, key, 0, 0});
}
static void up(Driven *d, int key) {
    session_event(d->session, &(DisplayEvent){DISPLAY_KEY_RELEASED, key, 0, 0});
}
static void strike(Driven *d, int key) {
    down(d, key);
    up(d, key);
}

static void pass(Driven *d, double seconds) {
    for (double until = d->now + seconds; d->now < until;) session_advance(d->session, d->now += 1.0 / 60);
}

static void draw(Driven *d, int width, int height) {
    Error error;
    cr_assert(session_draw(d->session, width, height, 1, &error), "%d x %d: %s", width, height, error.text);
}

static void expect_message(Driven *d, const char *part) {
    cr_expect(strstr(d->session->message, part), "`%s` does not say `%s`", d->session->message, part);
}

// Proves that holding W walks forward at a walk's pace, a wall ends it, and letting go stops.
Test(session, walks_while_a_key_is_held) {
    Driven d;
    begin(&d, "build/maps/house.plan");
    Vec3 start = d.session->person.eye;
    down(&d, 'W');
    pass(&d, 0.5);
    Vec3 later = d.session->person.eye;
    double way = hypot(later.x - start.x, later.y - start.y);
    cr_expect(way > 0.3 && way < 0.5 * PERSON_WALK * 1.1, "half a second's walk is %g m", way);
    up(&d, 'W');
    pass(&d, 0.5);
    Vec3 rest = d.session->person.eye;
    pass(&d, 0.5);
    cr_expect_lt(vec3_length(vec3_sub(rest, d.session->person.eye)), 0.01, "it stands");
    end(&d);
}

// Proves that time that nobody saw pass is not walked: after a stall of 5 s one is a quarter of a second further.
Test(session, a_stall_is_no_leap) {
    Driven d;
    begin(&d, "build/maps/house.plan");
    down(&d, 'W');
    Vec3 before = d.session->person.eye;
    session_advance(d.session, d.now += 5);
    Vec3 after = d.session->person.eye;
    cr_expect_lt(vec3_length(vec3_sub(after, before)), 0.25 * PERSON_WALK + 0.01);
    cr_expect_geq(vis_locate(d.session->shown->scene.graph, after, -1), 0);
    end(&d);
}

// Proves that a key that was down when the focus went is up afterwards: its release comes with the loss.
Test(session, focus_lost_lets_go) {
    Driven d;
    begin(&d, "build/maps/house.plan");
    down(&d, 'W');
    session_event(d.session, &(DisplayEvent){DISPLAY_BUTTON_PRESSED, DISPLAY_BUTTON_LEFT, 0, 0});
    cr_expect(session_wants_mouse(d.session));
    up(&d, 'W');
    session_event(d.session, &(DisplayEvent){DISPLAY_FOCUS_LOST, 0, 0, 0});
    cr_expect_not(session_wants_mouse(d.session), "the mouse is given back");
    pass(&d, 0.5);
    Vec3 rest = d.session->person.eye;
    pass(&d, 0.3);
    cr_expect_lt(vec3_length(vec3_sub(rest, d.session->person.eye)), 0.01, "it stands");
    end(&d);
}

// Proves that any size is drawn, 1 x 1 and back: the same view gives the same picture after.
Test(session, any_size_is_drawn) {
    Driven d;
    begin(&d, "build/maps/two-rooms.plan");
    enum { W = 160, H = 90 };
    uint8_t first[W * H * 3], last[W * H * 3];
    Error error;
    strike(&d, 'I');
    strike(&d, 'M');
    // The size, not a message, is tested.
    *d.session->message = '\0';
    draw(&d, W, H);
    cr_assert(session_read(d.session, first, &error), "%s", error.text);
    draw(&d, 1, 1);
    draw(&d, 3, 700);
    draw(&d, W, H);
    cr_assert(session_read(d.session, last, &error), "%s", error.text);
    cr_expect_arr_eq(first, last, sizeof first);
    end(&d);
}

// Proves that every key can be struck in any order, drawn after each, without harm; from a seed.
Test(session, any_key_at_any_time, .timeout = 240) {
    static const int KEYS[] = {'W',
                               'A',
                               'S',
                               'D',
                               ' ',
                               'C',
                               'E',
                               'O',
                               'F',
                               'M',
                               'I',
                               'H',
                               'V',
                               'N',
                               'B',
                               'X',
                               'T',
                               'G',
                               'R',
                               'L',
                               '0',
                               '1',
                               '2',
                               '9',
                               'Q',
                               'U',
                               'K',
                               '-',
                               '=',
                               DISPLAY_KEY_LEFT_SHIFT,
                               DISPLAY_KEY_PAGE_UP,
                               DISPLAY_KEY_PAGE_DOWN,
                               DISPLAY_KEY_F1,
                               DISPLAY_KEY_F5,
                               DISPLAY_KEY_F11};
    enum { KEY_COUNT = sizeof KEYS / sizeof *KEYS };
    Driven d;
    begin(&d, "build/maps/house.plan");
    uint64_t seed = 5;
    Random random = {seed};
    int held = 0;
    for (int i = 0; i < support_count(300, 20000); i++) {
        int key = KEYS[random_index(&random, KEY_COUNT)];
        if (held) up(&d, held);
        down(&d, held = key);
        session_event(d.session, &(DisplayEvent){DISPLAY_LOOK, 0, random_between(&random, -300, 300),
                                                 random_between(&random, -60, 60)});
        pass(&d, random_between(&random, 0, 0.4));
        if (i % 4 == 0) draw(&d, 64, 36);
        const Person *p = &d.session->person;
        cr_assert(isfinite(p->eye.x + p->eye.y + p->eye.z + p->yaw + p->pitch), "seed %llu, key %d at %d",
                  (unsigned long long)seed, key, i);
        cr_assert(p->flying || d.session->replay || p->cell >= 0,
                  "seed %llu: after key %d at %d the eye is in no cell", (unsigned long long)seed, key, i);
    }
    end(&d);
}

// Proves that a recorded path is replayed exactly: the same eyes, angles and doors to the last bit, and the same
// picture.
Test(session, replays_exactly) {
    Driven d;
    begin(&d, "build/maps/house.plan");
    enum { W = 96, H = 54, MOST = 400 };
    static Vec3 eyes[MOST];
    Session *s = d.session;
    strike(&d, 'R');
    int count = 0;
    down(&d, 'W');
    for (int i = 0; i < 120; i++) {
        if (i == 30) strike(&d, 'O');
        if (i == 60) down(&d, DISPLAY_KEY_LEFT);
        pass(&d, 1.0 / 60);
        for (; count < s->recording->frame_count; count++) eyes[count] = s->recording->frames[count].eye;
    }
    up(&d, 'W');
    up(&d, DISPLAY_KEY_LEFT);
    float *doors = ARENA_ARRAY(&d.arena, float, s->shown->scene.graph->building->opening_count);
    size_t size = sizeof *doors * (size_t)s->shown->scene.graph->building->opening_count;
    memcpy(doors, s->shown->doors.open, size);
    strike(&d, 'R');
    cr_assert_gt(count, 100);
    pass(&d, 2);
    strike(&d, '0');
    strike(&d, 'L');
    cr_assert(s->replay, "%s", s->message);
    cr_assert_eq(s->replay->frame_count, count);
    for (int i = 0; i < count; i++) {
        while (s->replay && s->replay_next <= i) session_advance(s, d.now += 1.0 / 120);
        cr_assert(vec3_equal(s->person.eye, eyes[i]), "tick %d", i);
    }
    cr_expect_arr_eq(s->shown->doors.open, doors, size);
    end(&d);
}

// Proves that a screenshot is a picture of the size drawn, under a name that no file had.
Test(session, takes_pictures) {
    Driven d;
    begin(&d, "build/maps/two-rooms.plan");
    for (int i = 0; i < 2; i++) {
        strike(&d, 'P');
        draw(&d, 120, 80);
    }
    for (int i = 1; i <= 2; i++) {
        uint8_t *rgb;
        int width, height;
        Error error;
        char *path = arena_format(&d.arena, "%s/enfilade-%04d.png", d.folder, i);
        cr_assert(image_read_png(path, &d.arena, &rgb, &width, &height, &error), "%s", error.text);
        cr_expect(width == 120 && height == 80, "%d x %d", width, height);
    }
    expect_message(&d, "enfilade-0002.png");
    end(&d);
}

// Proves that a walk is not recorded where it could not be written, and that one that cannot be written in the end is told of.
Test(session, recordings_that_cannot_be_kept) {
    Driven d;
    Error error = {""};
    begin(&d, "build/maps/two-rooms.plan");
    d.session->options.pictures = "/dev/null/pictures";
    strike(&d, 'R');
    expect_message(&d, "/dev/null/pictures: cannot be made");
    cr_expect_null(d.session->recording);
    d.session->options.pictures = d.folder;
    strike(&d, 'R');
    pass(&d, 0.5);
    cr_expect(d.session->recording);
    d.session->options.pictures = "/dev/null/pictures";
    cr_expect_not(session_keep_recording(d.session, &error));
    cr_expect(strstr(error.text, "/dev/null/pictures: cannot be made"), "%s", error.text);
    end(&d);
}

// ---- killed while it writes

typedef struct Kept {
    Driven *walk;
    const char *path;
} Kept;

static void end_recording(void *context) { strike(((Kept *)context)->walk, 'R'); }

// Proves that a walk that is killed while it writes what it recorded leaves no path or the whole of it, and that the next one that is
// written leaves nothing else.
Test(session, killed_while_it_keeps_a_recording, .timeout = 600) {
    Driven d;
    Error error;
    begin(&d, "build/maps/two-rooms.plan");
    Kept kept = {&d, arena_format(&d.arena, "%s/enfilade-0001.path", d.folder)};
    strike(&d, 'R');
    down(&d, 'W');
    pass(&d, 2);
    const Building *building = d.session->shown->scene.graph->building;
    int frames = d.session->recording->frame_count, moments = support_kill(-1, end_recording, &kept);
    cr_assert(frames > 100 && moments > 10);
    Bytes whole = support_read(&d.arena, kept.path);
    for (int i = 0; i < support_count(moments, 1000); i++) {
        Arena scratch = {0};
        unlink(kept.path);
        cr_assert_eq(support_kill(i % moments, end_recording, &kept), -1);
        if (access(kept.path, F_OK) == 0) {
            Bytes now = support_read(&scratch, kept.path);
            cr_expect(now.size == whole.size && memcmp(now.data, whole.data, now.size) == 0, "killed at %d",
                      i % moments);
            Recording *read = recording_load(kept.path, building, &scratch, &error);
            cr_expect(read && read->frame_count == frames, "%s", error.text);
        }
        cr_assert(recording_save(d.session->recording, kept.path, &error), "%s", error.text);
        char *others;
        support_run(&scratch, &others, "ls -A %s | grep -vx -e two-rooms.plan -e enfilade-0001.path",
                    d.folder);
        cr_expect_str_eq(others, "", "killed at %d", i % moments);
        arena_free(&scratch);
    }
    end(&d);
}

static void walk_on(void *context) { pass(((Kept *)context)->walk, 1); }

// Proves that whatever a killed walk wrote of its trace are whole lines.
Test(session, killed_while_it_traces, .timeout = 600) {
    Driven d;
    Error error;
    begin(&d, "build/maps/two-rooms.plan");
    const char *path = d.session->options.trace = arena_format(&d.arena, "%s/trace", d.folder);
    Kept kept = {&d, path};
    cr_assert(session_open_trace(d.session, &error), "%s", error.text);
    int moments = support_kill(-1, walk_on, &kept), lines = 0;
    cr_assert_gt(moments, 10);
    for (int i = 0; i < support_count(moments, 1000); i++) {
        Arena scratch = {0};
        cr_assert_eq(ftruncate(d.session->trace, 0) + (int)lseek(d.session->trace, 0, SEEK_SET), 0);
        cr_assert_eq(support_kill(i % moments, walk_on, &kept), -1);
        Bytes text = support_read(&scratch, path);
        for (size_t at = 0; at < text.size; lines++) {
            const char *line = (char *)text.data + at, *stop = memchr(line, '\n', text.size - at);
            cr_assert(stop && *line == '{' && stop[-1] == '}', "killed at %d: %s", i % moments, line);
            at += (size_t)(stop + 1 - line);
        }
        arena_free(&scratch);
    }
    cr_expect_gt(lines, moments);
    end(&d);
}

static void write_text(Driven *d, const char *text) {
    Error error;
    cr_assert(file_write(d->file, text, strlen(text), &error), "%s", error.text);
}

// Proves that a file changed under the walk is read again where one stands; that one which is broken or gone is told
// of, and what was shown stays.
Test(session, reloads_what_changed) {
    Driven d;
    begin(&d, "build/maps/two-rooms.plan");
    pass(&d, 0.5);
    Vec3 eye = d.session->person.eye;
    const CellGraph *before = d.session->shown->scene.graph;
    int polygons = before->polygon_count;
    char *text = (char *)support_read(&d.arena, d.file).data;
    write_text(
        &d,
        arena_format(
            &d.arena,
            "%s\nlight new 1,1,2 flux 1\nmodel extra\n  box 0,0,0 0.1,0.1,0.1 plain\nend\nplace extra 1,1\n",
            text));
    pass(&d, 1);
    expect_message(&d, "read again");
    cr_expect_gt(d.session->shown->scene.graph->polygon_count, polygons);
    cr_expect_lt(vec3_length(vec3_sub(eye, d.session->person.eye)), 0.5, "one stands where one stood");
    write_text(&d, "plan 1\nnonsense\n");
    pass(&d, 1);
    expect_message(&d, ":2:");
    cr_expect_gt(d.session->shown->scene.graph->polygon_count, polygons, "the last good one is shown");
    draw(&d, 64, 36);
    unlink(d.file);
    pass(&d, 1);
    expect_message(&d, "gone");
    draw(&d, 64, 36);
    write_text(&d, text);
    pass(&d, 1);
    expect_message(&d, "read again");
    cr_expect_eq(d.session->shown->scene.graph->polygon_count, polygons);
    write_text(&d, arena_format(&d.arena, "%s# changed\n", text));
    strike(&d, DISPLAY_KEY_F5);
    const Shown *by_hand = d.session->shown;
    pass(&d, 1);
    cr_expect_eq(d.session->shown, by_hand, "what F5 has read is read once more");
    end(&d);
}

// Proves that E opens the door looked at, which then stays open, and closes it again; and that freezing keeps what is
// visible while the eye goes on.
Test(session, opens_doors_and_freezes) {
    Driven d;
    begin(&d, "build/maps/two-rooms.plan");
    Session *s = d.session;
    const Building *b = s->shown->scene.graph->building;
    // In front of the door between the rooms.
    const Opening *o = &b->openings[0];
    Vec2 middle = vec2_scale(vec2_add(o->line[0], o->line[1]), 0.5);
    person_put(&s->person, &s->shown->world, vec3(middle.x - 1.2, middle.y, 1.6), 0, 0);
    cr_assert_eq(session_door(s), 0, "the door is looked at");
    strike(&d, 'E');
    pass(&d, 3);
    cr_expect_eq(s->shown->doors.open[0], 1.0f);
    draw(&d, 64, 36);
    int cells = s->visible.cell_count;
    strike(&d, 'V');
    person_look(&s->person, M_PI, 0);
    draw(&d, 64, 36);
    cr_expect_eq(s->visible.cell_count, cells);
    strike(&d, 'V');
    draw(&d, 64, 36);
    cr_expect_neq(s->visible.cell_count, cells);
    person_look(&s->person, M_PI, 0);
    strike(&d, 'E');
    pass(&d, 3);
    cr_expect_eq(s->shown->doors.open[0], 0.0f);
    end(&d);
}
