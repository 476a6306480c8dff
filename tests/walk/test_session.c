// test_session.c - a walk as its user drives it, without a window: keys and the mouse go in, frames and files come out.
#include <criterion/criterion.h>

#include "engine/walk/session.h"
#include "engine/walk/session_state.h"
#include "tests/support/support.h"
#include "tests/walk/session_fixture.h"

// Proves that holding W walks forward at a walk's pace, a wall ends it, and letting go stops.
Test(session, walks_while_a_key_is_held) {
    Driven d;
    session_check_begin(&d, "build/maps/house.plan");
    Vec3 start = d.session->person.eye;
    session_check_down(&d, 'W');
    session_check_pass(&d, 0.5);
    Vec3 later = d.session->person.eye;
    double way = hypot(later.x - start.x, later.y - start.y);
    cr_expect(way > 0.3 && way < 0.5 * PERSON_WALK * 1.1, "half a second's walk is %g m", way);
    session_check_up(&d, 'W');
    session_check_pass(&d, 0.5);
    Vec3 rest = d.session->person.eye;
    session_check_pass(&d, 0.5);
    cr_expect_lt(vec3_length(vec3_sub(rest, d.session->person.eye)), 0.01, "it stands");
    session_check_end(&d);
}

// Proves that time that nobody saw pass is not walked: after a stall of 5 s one is a quarter of a second further.
Test(session, a_stall_is_no_leap) {
    Driven d;
    session_check_begin(&d, "build/maps/house.plan");
    session_check_down(&d, 'W');
    Vec3 before = d.session->person.eye;
    session_advance(d.session, d.now += 5);
    Vec3 after = d.session->person.eye;
    cr_expect_lt(vec3_length(vec3_sub(after, before)), 0.25 * PERSON_WALK + 0.01);
    cr_expect_geq(vis_locate(d.session->shown->scene.graph, after, -1), 0);
    session_check_end(&d);
}

// Proves that a key that was down when the focus went is up afterwards: its release comes with the loss.
Test(session, focus_lost_lets_go) {
    Driven d;
    session_check_begin(&d, "build/maps/house.plan");
    session_check_down(&d, 'W');
    session_event(d.session, &(DisplayEvent){DISPLAY_BUTTON_PRESSED, DISPLAY_BUTTON_LEFT, 0, 0});
    cr_expect(session_wants_mouse(d.session));
    session_check_up(&d, 'W');
    session_event(d.session, &(DisplayEvent){DISPLAY_FOCUS_LOST, 0, 0, 0});
    cr_expect_not(session_wants_mouse(d.session), "the mouse is given back");
    session_check_pass(&d, 0.5);
    Vec3 rest = d.session->person.eye;
    session_check_pass(&d, 0.3);
    cr_expect_lt(vec3_length(vec3_sub(rest, d.session->person.eye)), 0.01, "it stands");
    session_check_end(&d);
}

// Proves that any size is drawn, 1 x 1 and back: the same view gives the same picture after.
Test(session, any_size_is_drawn) {
    Driven d;
    session_check_begin(&d, "build/maps/two-rooms.plan");
    enum { W = 160, H = 90 };
    uint8_t first[W * H * 3], last[W * H * 3];
    Error error;
    session_check_strike(&d, 'I');
    session_check_strike(&d, 'M');
    // The size, not a message, is tested.
    *d.session->message = '\0';
    session_check_draw(&d, W, H);
    cr_assert(session_read(d.session, first, &error), "%s", error.text);
    session_check_draw(&d, 1, 1);
    session_check_draw(&d, 3, 700);
    session_check_draw(&d, W, H);
    cr_assert(session_read(d.session, last, &error), "%s", error.text);
    cr_expect_arr_eq(first, last, sizeof first);
    session_check_end(&d);
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
                               ',',
                               '.',
                               DISPLAY_KEY_LEFT_SHIFT,
                               DISPLAY_KEY_PAGE_UP,
                               DISPLAY_KEY_PAGE_DOWN,
                               DISPLAY_KEY_F1,
                               DISPLAY_KEY_F5,
                               DISPLAY_KEY_F11};
    enum { KEY_COUNT = sizeof KEYS / sizeof *KEYS };
    Driven d;
    session_check_begin(&d, "build/maps/house.plan");
    uint64_t seed = 5;
    Random random = {seed};
    int held = 0;
    for (int i = 0; i < support_count(300, 20000); i++) {
        int key = KEYS[random_index(&random, KEY_COUNT)];
        if (held) session_check_up(&d, held);
        session_check_down(&d, held = key);
        session_event(d.session, &(DisplayEvent){DISPLAY_LOOK, 0, random_between(&random, -300, 300),
                                                 random_between(&random, -60, 60)});
        session_check_pass(&d, random_between(&random, 0, 0.4));
        if (i % 4 == 0) session_check_draw(&d, 64, 36);
        const Person *p = &d.session->person;
        cr_assert(isfinite(p->eye.x + p->eye.y + p->eye.z + p->yaw + p->pitch), "seed %llu, key %d at %d",
                  (unsigned long long)seed, key, i);
        cr_assert(p->flying || d.session->replay || p->cell >= 0,
                  "seed %llu: after key %d at %d the eye is in no cell", (unsigned long long)seed, key, i);
    }
    session_check_end(&d);
}

// Proves that a recorded path is replayed exactly: the same eyes, angles and doors to the last bit, and the same
// picture.
Test(session, replays_exactly) {
    Driven d;
    session_check_begin(&d, "build/maps/house.plan");
    enum { W = 96, H = 54, MOST = 400 };
    static Vec3 eyes[MOST];
    Session *s = d.session;
    session_check_strike(&d, 'R');
    int count = 0;
    session_check_down(&d, 'W');
    for (int i = 0; i < 120; i++) {
        if (i == 30) session_check_strike(&d, 'O');
        if (i == 60) session_check_down(&d, DISPLAY_KEY_LEFT);
        session_check_pass(&d, 1.0 / 60);
        for (; count < s->recording->frame_count; count++) eyes[count] = s->recording->frames[count].eye;
    }
    session_check_up(&d, 'W');
    session_check_up(&d, DISPLAY_KEY_LEFT);
    float *doors = ARENA_ARRAY(&d.arena, float, s->shown->scene.graph->building->opening_count);
    size_t size = sizeof *doors * (size_t)s->shown->scene.graph->building->opening_count;
    memcpy(doors, s->shown->doors.open, size);
    session_check_strike(&d, 'R');
    cr_assert_gt(count, 100);
    session_check_pass(&d, 2);
    session_check_strike(&d, '0');
    session_check_strike(&d, 'L');
    cr_assert(s->replay, "%s", s->message);
    cr_assert_eq(s->replay->frame_count, count);
    for (int i = 0; i < count; i++) {
        while (s->replay && s->replay_next <= i) session_advance(s, d.now += 1.0 / 120);
        cr_assert(vec3_equal(s->person.eye, eyes[i]), "tick %d", i);
    }
    cr_expect_arr_eq(s->shown->doors.open, doors, size);
    session_check_end(&d);
}
