// test_doors.c - doors over time: they arrive, they wait for whoever is in the way and for one another, and go on when it is free.
#include <criterion/criterion.h>

#include "engine/sim/doors.h"
#include "tests/sim/doors_fixture.h"
#include "tests/support/support.h"

// ---- an oracle for leaves: corners and edges, no more

static bool apart_along_edges(const Vec2 a[4], const Vec2 b[4]) {
    for (int i = 0; i < 4; i++) {
        Vec2 edge = vec2_sub(a[(i + 1) % 4], a[i]);
        bool all_right = true;
        for (int k = 0; k < 4; k++) all_right = all_right && vec2_cross(edge, vec2_sub(b[k], a[i])) <= 0;
        if (all_right) return true;
    }
    return false;
}

static double distance_to_leaf(const Leaf *leaf, double open, Vec2 p) {
    Vec2 box[4];
    double nearest = INFINITY;
    bool inside = true;
    leaf_box(leaf, open, box);
    for (int i = 0; i < 4; i++) {
        Vec2 edge = vec2_sub(box[(i + 1) % 4], box[i]), to = vec2_sub(p, box[i]);
        double t = fmin(fmax(vec2_dot(to, edge) / vec2_dot(edge, edge), 0), 1);
        nearest = fmin(nearest, vec2_length(vec2_sub(to, vec2_scale(edge, t))));
        inside = inside && vec2_cross(edge, to) >= 0;
    }
    return inside ? 0 : nearest;
}

// No leaf in another, none in the body.
static void expect_clear(const Made *m) {
    const Building *b = &m->building;
    Vec2 at = vec2(m->body.foot.x, m->body.foot.y);
    for (int i = 0; i < b->leaf_count; i++) {
        double open = (double)m->doors.open[b->leaves[i].opening];
        Vec2 box[4];
        leaf_box(&b->leaves[i], open, box);
        cr_assert_geq(distance_to_leaf(&b->leaves[i], open, at), BODY_RADIUS, "leaf %d touches the body", i);
        for (int k = 0; k < i; k++) {
            Vec2 other[4];
            leaf_box(&b->leaves[k], (double)m->doors.open[b->leaves[k].opening], other);
            cr_assert(apart_along_edges(box, other) || apart_along_edges(other, box),
                      "leaves %d and %d lie in one another", i, k);
        }
    }
}

static void pass(Made *m, double seconds) {
    for (double t = 0; t < seconds; t += 1.0 / 120) {
        doors_advance(&m->doors, 1.0 / 120, &m->body);
        expect_clear(m);
    }
}

// Proves that every kind of door opens all the way, over time and not at once, and closes to exactly nothing: single,
// double, sliding, glazed, and one drawn ajar.
Test(doors, open_and_close) {
    static const char *const DOORS[] = {
        "door d 4.075,1.5 angle 90 width 0.9 height 2\n",
        "door d 4.075,1.5 angle 90 width 1.6 height 2 hinge both swing -85\n",
        "door d 4.075,1.5 angle 90 width 0.9 height 2 slide 0.85\n",
        "door d 4.075,1.5 angle 90 width 1.6 height 2 hinge both slide 0.7\n",
        "door d 4.075,1.5 angle 90 width 1.4 height 2 hinge both swing 88 glazed\n",
        "door d 4.075,1.5 angle 90 width 0.9 height 2 hinge right swing 100 open 0.3\n"};
    for (size_t i = 0; i < sizeof DOORS / sizeof *DOORS; i++) {
        Made m;
        doors_check_make(&m, DOORS[i]);
        bool ajar = m.doors.open[0] > 0;
        cr_assert(ajar == (i == 5) && (!ajar || m.doors.open[0] == 0.3f), "door %zu begins as drawn", i);
        cr_assert(doors_toggle(&m.doors, 0));
        pass(&m, 0.2);
        cr_expect(m.doors.open[0] > 0 && m.doors.open[0] < 1, "door %zu is on its way, at %g", i,
                  (double)m.doors.open[0]);
        pass(&m, 3);
        cr_expect_eq(m.doors.open[0], 1.0f, "door %zu", i);
        cr_assert(doors_toggle(&m.doors, 0));
        pass(&m, 3);
        cr_expect_eq(m.doors.open[0], 0.0f, "door %zu", i);
        arena_free(&m.arena);
    }
}

// Proves that a door halts before whoever stands in its doorway, wherever in it, and closes when they have gone.
Test(doors, wait_for_the_body) {
    for (int i = 0; i <= 10; i++) {
        Made m;
        doors_check_make(&m, "door d 4.075,1.5 angle 90 width 0.9 height 2 hinge left swing -88\n");
        doors_set(&m.doors, 0, 1);
        double x = 4.075 + 0.1 * (i - 5);
        cr_assert(body_place_near(&m.body, &m.world, vec3(x, 1.55, 0)));
        doors_toggle(&m.doors, 0);
        pass(&m, 5);
        bool in_the_way =
            distance_to_leaf(&m.building.leaves[0], 0, vec2(m.body.foot.x, m.body.foot.y)) < BODY_RADIUS;
        if (in_the_way) {
            cr_expect_gt(m.doors.open[0], 0.0f, "at x = %g the door closes onto the body", x);
            cr_expect_eq(m.doors.halt[0], DOOR_MEETS_BODY);
        }
        for (int k = 0; k < 300; k++) body_step(&m.body, &m.world, vec2(-0.01, 0), 0.01);
        pass(&m, 5);
        cr_expect_eq(m.doors.open[0], 0.0f, "from x = %g: it closes when the way is free", x);
        arena_free(&m.arena);
    }
}

// Proves that nobody passes a closed door, of glass or not, nor a leaf that stands half open in the way.
Test(doors, hold_the_body) {
    for (int glazed = 0; glazed < 2; glazed++) {
        for (int half = 0; half < 2; half++) {
            Made m;
            doors_check_make(&m, glazed ? "door d 4.075,1.5 angle 90 width 0.9 height 2 glazed\n"
                                        : "door d 4.075,1.5 angle 90 width 0.9 height 2\n");
            doors_set(&m.doors, 0, half ? 0.25f : 0);
            cr_assert(body_place_near(&m.body, &m.world, vec3(3, 1.5, 0)));
            for (int k = 0; k < 400; k++) body_step(&m.body, &m.world, vec2(0.01, 0), 0.01);
            cr_expect_lt(m.body.foot.x, 4.075, "glazed %d, half %d", glazed, half);
            doors_set(&m.doors, 0, 1);
            for (int k = 0; k < 400; k++) body_step(&m.body, &m.world, vec2(0.01, 0), 0.01);
            cr_expect_gt(m.body.foot.x, 5, "glazed %d: open, it lets pass", glazed);
            arena_free(&m.arena);
        }
    }
}

// Proves that two doors hung on one jamb both open, at once or one after the other, and never through one another.
Test(doors, share_a_jamb) {
    for (int delay = 0; delay < 4; delay++) {
        Made m;
        doors_check_make(&m, "door a 4.075,1.0 angle 90 width 0.9 height 2 hinge right swing 88\n"
                             "door b 4.075,2.0 angle 90 width 0.9 height 2 hinge left swing -88\n"
                             "door c 4.075,3.0 angle 90 width 0.9 height 2 hinge left swing -88\n");
        doors_toggle(&m.doors, 0);
        pass(&m, 0.2 * delay);
        doors_toggle(&m.doors, 1);
        doors_toggle(&m.doors, 2);
        pass(&m, 4);
        for (int i = 0; i < 3; i++) cr_expect_eq(m.doors.open[i], 1.0f, "door %d, delay %d", i, delay);
        arena_free(&m.arena);
    }
}

// Proves that a door which would swing into another waits for it, and goes on when that one has closed.
Test(doors, wait_for_one_another) {
    Made m;
    doors_check_make(&m, "door a 4.075,1.0 angle 90 width 0.9 height 2 hinge left swing -88\n"
                         "door b 4.8,-0.075 width 0.9 height 2 hinge left swing 88\n");
    doors_toggle(&m.doors, 0);
    pass(&m, 3);
    cr_assert_eq(m.doors.open[0], 1.0f);
    doors_toggle(&m.doors, 1);
    pass(&m, 5);
    cr_expect(m.doors.open[1] > 0 && m.doors.open[1] < 1, "it stands at %g", (double)m.doors.open[1]);
    cr_expect_eq(m.doors.halt[1], DOOR_MEETS_DOOR);
    doors_toggle(&m.doors, 0);
    pass(&m, 5);
    cr_expect_eq(m.doors.open[0], 0.0f);
    cr_expect_eq(m.doors.open[1], 1.0f, "the way is free");
    arena_free(&m.arena);
}

// Metres between leaves 0 and 1, which do not overlap: at a corner of one of them.
static double leaf_gap(const Made *m) {
    double gap = INFINITY;
    for (int i = 0; i < 2; i++) {
        const Leaf *one = &m->building.leaves[i], *other = &m->building.leaves[1 - i];
        Vec2 box[4];
        leaf_box(one, (double)m->doors.open[one->opening], box);
        for (int k = 0; k < 4; k++)
            gap = fmin(gap, distance_to_leaf(other, (double)m->doors.open[other->opening], box[k]));
    }
    return gap;
}

// Proves that leaves halt a centimetre before one another and before a body, and no farther off than a step of another centimetre,
// in frames of any length: what is in the way of a long one is not passed over. 1e-6: shares are floats.
Test(doors, halt_a_centimetre_off) {
    static const double FRAMES[] = {1.0 / 240, 1.0 / 30, 0.2, 3};
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 8; k++) {
            Made m;
            doors_check_make(&m, "door a 4.075,1.0 angle 90 width 0.9 height 2 hinge left swing -88\n"
                                 "door b 4.8,-0.075 width 0.9 height 2 hinge left swing 88\n");
            doors_set(&m.doors, 0, 0.65f + 0.05f * (float)k);
            doors_toggle(&m.doors, 1);
            for (double t = 0; t < 3; t += FRAMES[i]) doors_advance(&m.doors, FRAMES[i], NULL);
            double gap = leaf_gap(&m);
            cr_expect_eq(m.doors.halt[1], DOOR_MEETS_DOOR);
            cr_expect(gap > 0.01 - 1e-6 && gap < 0.02 + 1e-6, "%g m to the other leaf, frames of %g s, %d",
                      gap, FRAMES[i], k);
            arena_free(&m.arena);

            doors_check_make(&m, "door d 4.075,1.5 angle 90 width 0.9 height 2 hinge left swing -88\n");
            doors_set(&m.doors, 0, 1);
            cr_assert(body_place_near(&m.body, &m.world, vec3(3.95 + 0.02 * k, 1.55, 0)));
            doors_toggle(&m.doors, 0);
            for (double t = 0; t < 3; t += FRAMES[i]) doors_advance(&m.doors, FRAMES[i], &m.body);
            Vec2 at = vec2(m.body.foot.x, m.body.foot.y);
            gap = distance_to_leaf(&m.building.leaves[0], (double)m.doors.open[0], at) - BODY_RADIUS;
            cr_expect_eq(m.doors.halt[0], DOOR_MEETS_BODY);
            cr_expect(gap > 0.01 - 1e-6 && gap < 0.02 + 1e-6, "%g m to the body, frames of %g s, %d", gap,
                      FRAMES[i], k);
            arena_free(&m.arena);
        }
    }
}

// Proves that an opening takes the time it should, in frames of any length.
Test(doors, open_in_nine_tenths_of_a_second) {
    for (int frames = 1; frames <= 100; frames *= 10) {
        Made m;
        doors_check_make(&m, "door d 4.075,1.5 angle 90 width 0.9 height 2\n");
        doors_toggle(&m.doors, 0);
        for (int i = 0; i < frames; i++) doors_advance(&m.doors, 0.45 / frames, NULL);
        cr_expect_float_eq(m.doors.open[0], 0.5, 1e-4, "halfway in half the time, %d frames", frames);
        doors_toggle(&m.doors, 0);
        doors_toggle(&m.doors, 0);
        doors_advance(&m.doors, 0.4501, NULL);
        cr_expect_eq(m.doors.open[0], 1.0f);
        arena_free(&m.arena);
    }
}

// Proves that no door is used through a window, which lets sight through but no hand; through a passage it is.
Test(doors, are_not_used_through_windows) {
    static const char DOOR[] = "door b 8.225,1.5 angle 90 width 0.9 height 2\n";
    static const char *const BETWEEN[] = {"window w 4.075,1.5 angle 90 width 1 sill 0.5 height 1.8\n",
                                          "passage p 4.075,1.5 angle 90 width 1 height 2.3\n"};
    for (int i = 0; i < 2; i++) {
        Made m;
        Arena arena = {0};
        doors_check_make(&m, arena_format(&arena, "%s%s", BETWEEN[i], DOOR));
        arena_free(&arena);
        for (int k = -4; k <= 4; k++) {
            Vec3 eye = vec3(2.5, 1.5 + 0.05 * k, 1.6);
            int found = doors_looked_at(&m.doors, eye, vis_locate(&m.graph, eye, -1), vec3(1, 0, 0), 10);
            cr_expect_eq(found, i == 0 ? -1 : 1, "opening %d is meant, %d", found, k);
        }
        arena_free(&m.arena);
    }
}
