// test_session_files.c - pictures and recordings of a walk, kills while it writes, and files that change.
#include <criterion/criterion.h>
#include <unistd.h>

#include "engine/draw/image.h"
#include "engine/walk/session.h"
#include "engine/walk/session_state.h"
#include "tests/support/support.h"
#include "tests/walk/session_fixture.h"

static void expect_message(Driven *d, const char *part) {
    cr_expect(strstr(d->session->message, part), "`%s` does not say `%s`", d->session->message, part);
}

// Proves that a screenshot is a picture of the size drawn, under a name that no file had.
Test(session, takes_pictures) {
    Driven d;
    session_check_begin(&d, "build/maps/two-rooms.plan");
    for (int i = 0; i < 2; i++) {
        session_check_strike(&d, 'P');
        session_check_draw(&d, 120, 80);
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
    session_check_end(&d);
}

// Proves that a walk is not recorded where it could not be written, and that one that cannot be written in the end is told of.
Test(session, recordings_that_cannot_be_kept) {
    Driven d;
    Error error = {""};
    session_check_begin(&d, "build/maps/two-rooms.plan");
    d.session->options.pictures = "/dev/null/pictures";
    session_check_strike(&d, 'R');
    expect_message(&d, "/dev/null/pictures: cannot be made");
    cr_expect_null(d.session->recording);
    d.session->options.pictures = d.folder;
    session_check_strike(&d, 'R');
    session_check_pass(&d, 0.5);
    cr_expect(d.session->recording);
    d.session->options.pictures = "/dev/null/pictures";
    cr_expect_not(session_keep_recording(d.session, &error));
    cr_expect(strstr(error.text, "/dev/null/pictures: cannot be made"), "%s", error.text);
    session_check_end(&d);
}

// ---- killed while it writes

typedef struct Kept {
    Driven *walk;
    const char *path;
} Kept;

static void end_recording(void *context) { session_check_strike(((Kept *)context)->walk, 'R'); }

// Proves that a walk that is killed while it writes what it recorded leaves no path or the whole of it, and that the next one that is
// written leaves nothing else.
Test(session, killed_while_it_keeps_a_recording, .timeout = 600) {
    Driven d;
    Error error;
    session_check_begin(&d, "build/maps/two-rooms.plan");
    Kept kept = {&d, arena_format(&d.arena, "%s/enfilade-0001.path", d.folder)};
    session_check_strike(&d, 'R');
    session_check_down(&d, 'W');
    session_check_pass(&d, 2);
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
    session_check_end(&d);
}

static void walk_on(void *context) { session_check_pass(((Kept *)context)->walk, 1); }

// Proves that whatever a killed walk wrote of its trace are whole lines.
Test(session, killed_while_it_traces, .timeout = 600) {
    Driven d;
    Error error;
    session_check_begin(&d, "build/maps/two-rooms.plan");
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
    session_check_end(&d);
}

static void write_text(Driven *d, const char *text) {
    Error error;
    cr_assert(file_write(d->file, text, strlen(text), &error), "%s", error.text);
}

// Proves that a file changed under the walk is read again where one stands; that one which is broken or gone is told
// of, and what was shown stays.
Test(session, reloads_what_changed) {
    Driven d;
    session_check_begin(&d, "build/maps/two-rooms.plan");
    session_check_pass(&d, 0.5);
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
    session_check_pass(&d, 1);
    expect_message(&d, "read again");
    cr_expect_gt(d.session->shown->scene.graph->polygon_count, polygons);
    cr_expect_lt(vec3_length(vec3_sub(eye, d.session->person.eye)), 0.5, "one stands where one stood");
    write_text(&d, "plan 1\nnonsense\n");
    session_check_pass(&d, 1);
    expect_message(&d, ":2:");
    cr_expect_gt(d.session->shown->scene.graph->polygon_count, polygons, "the last good one is shown");
    session_check_draw(&d, 64, 36);
    unlink(d.file);
    session_check_pass(&d, 1);
    expect_message(&d, "gone");
    session_check_draw(&d, 64, 36);
    write_text(&d, text);
    session_check_pass(&d, 1);
    expect_message(&d, "read again");
    cr_expect_eq(d.session->shown->scene.graph->polygon_count, polygons);
    write_text(&d, arena_format(&d.arena, "%s# changed\n", text));
    session_check_strike(&d, DISPLAY_KEY_F5);
    const Shown *by_hand = d.session->shown;
    session_check_pass(&d, 1);
    cr_expect_eq(d.session->shown, by_hand, "what F5 has read is read once more");
    session_check_end(&d);
}

// Proves that E opens the door looked at, which then stays open, and closes it again; and that freezing keeps what is
// visible while the eye goes on.
Test(session, opens_doors_and_freezes) {
    Driven d;
    session_check_begin(&d, "build/maps/two-rooms.plan");
    Session *s = d.session;
    const Building *b = s->shown->scene.graph->building;
    // In front of the door between the rooms.
    const Opening *o = &b->openings[0];
    Vec2 middle = vec2_scale(vec2_add(o->line[0], o->line[1]), 0.5);
    person_put(&s->person, &s->shown->world, vec3(middle.x - 1.2, middle.y, 1.6), 0, 0);
    cr_assert_eq(session_door(s), 0, "the door is looked at");
    session_check_strike(&d, 'E');
    session_check_pass(&d, 3);
    cr_expect_eq(s->shown->doors.open[0], 1.0f);
    session_check_draw(&d, 64, 36);
    int cells = s->visible.cell_count;
    session_check_strike(&d, 'V');
    person_look(&s->person, M_PI, 0);
    session_check_draw(&d, 64, 36);
    cr_expect_eq(s->visible.cell_count, cells);
    session_check_strike(&d, 'V');
    session_check_draw(&d, 64, 36);
    cr_expect_neq(s->visible.cell_count, cells);
    person_look(&s->person, M_PI, 0);
    session_check_strike(&d, 'E');
    session_check_pass(&d, 3);
    cr_expect_eq(s->shown->doors.open[0], 0.0f);
    session_check_end(&d);
}
