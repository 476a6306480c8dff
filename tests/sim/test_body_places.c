// test_body_places.c - places where bodies usually fail, each by its name.
#include <criterion/criterion.h>

#include "engine/sim/doors.h"
#include "tests/sim/body_fixture.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"

// Walks so far, and expects to arrive within a millimetre.
static void go(Walker *w, double x, double y, const char *where) {
    Vec3 start = w->body.foot;
    body_step(&w->body, &w->world, vec2(x, y), 0.05);
    body_check_expect_free(w, where);
    cr_assert(hypot(w->body.foot.x - start.x - x, w->body.foot.y - start.y - y) < 1e-3,
              "%s: from %g, %g by %g, %g it came to %g, %g", where, start.x, start.y, x, y, w->body.foot.x,
              w->body.foot.y);
}

// ---- where such bodies fail

// Proves that the axis may be exactly on a portal's plane: placed there, walking along it, across it and back.
Test(body, on_the_plane_of_a_portal) {
    Walker w;
    body_check_open_plan(&w, ROOMS "passage p 4.1,2 angle 90 width 1.2 height 2.1\n");
    body_check_stand(&w, 4, 2, 0);
    go(&w, 0, 0.2, "along the plane");
    go(&w, 0, -0.4, "back along it");
    go(&w, 1, 0, "across it");
    body_check_stand(&w, 4.2, 2, 0);
    go(&w, 0, 0.3, "along the other plane");
    go(&w, -1, 0, "across both");
    arena_free(&w.arena);
}

// Proves that a corner where four cells meet is passed in every direction. A column in the middle of a room makes the
// cells; the corner is where their portals end, found as a vertex of four cells that no wall touches.
static int cells_at(const CellGraph *g, Vec2 p) {
    int count = 0;
    for (int c = 0; c < g->cell_count; c++) {
        for (int i = 0; i < g->cells[c].edge_count; i++)
            count += vec2_equal(g->plan[g->cells[c].first_edge + i], p);
    }
    return count;
}

// Four low kerbs of a raised floor meet: their rooms' outlines share the corner.
Test(body, in_a_corner_where_four_cells_meet) {
    Walker w;
    body_check_open_plan(&w,
                         HEAD "storey s floor 0 height 2.6\nroom a 0,0 4,0 4,4 0,4\nroom b 4,0 8,0 8,4 4,4\n"
                              "room c 0,4 4,4 4,8 0,8\nroom d 4,4 8,4 8,8 4,8\n"
                              "wall 0,0 8,0 8,8 0,8 0,0 thickness 0.2\n");
    cr_assert_geq(cells_at(&w.graph, vec2(4, 4)), 4, "the corner is not shared");
    for (int i = 0; i < 64; i++) {
        double x = cos(2 * M_PI * i / 64), y = sin(2 * M_PI * i / 64);
        body_check_stand(&w, 4, 4, 0);
        go(&w, x, y, "away from the corner");
        go(&w, -x, -y, "on to it");
        go(&w, -x, -y, "over it");
        go(&w, 2 * x, 2 * y, "over it at once");
    }
    arena_free(&w.arena);
}

// Proves that a way exactly through the end of a portal, the jamb, is stopped a radius before it; and that a way that
// only just clears the jamb passes.
Test(body, through_the_end_of_a_portal) {
    Walker w;
    body_check_open_plan(&w, ROOMS "passage p 4.1,2 angle 90 width 1.2 height 2.1\n");
    body_check_stand(&w, 3, 1.4, 0);
    body_check_expect_stop(&w, 0.9, 0, 0.8 - 1e-4, "straight at the jamb");
    body_check_stand(&w, 3, 1.4 + BODY_RADIUS + 2e-4, 0);
    go(&w, 2, 0, "just past the jamb");
    body_check_stand(&w, 3, 0.4, 0);
    body_step(&w.body, &w.world, vec2(1.0, 1.0), 0);
    body_check_expect_free(&w, "aslant at the jamb");
    arena_free(&w.arena);
}

// Proves that one step through five cells ends in the right one, and that the same step is stopped by a closed door.
Test(body, a_step_through_several_cells) {
    Walker w;
    body_check_open_plan(&w, ROOMS "door d 4.1,2 angle 90 width 1.2 height 2.1\n");
    doors_set(&w.doors, 0, 1);
    body_check_stand(&w, 1, 2, 0);
    go(&w, 4.5, 0, "through the open door");
    go(&w, -4.5, 0, "and back");
    doors_set(&w.doors, 0, 0);
    Vec3 start = w.body.foot;
    body_step(&w.body, &w.world, vec2(4.5, 0), 0);
    body_check_expect_free(&w, "at the closed door");
    cr_assert(w.body.foot.x > start.x + 2 && w.body.foot.x < 4.1 - BODY_RADIUS, "it stands at %g",
              w.body.foot.x);
    arena_free(&w.arena);
}

// Proves that no step of 5 m, nor one of 5 s, leads through a wall: from everywhere in a room without doors.
Test(body, long_steps_do_not_tunnel) {
    Walker w;
    Random r = {31};
    body_check_open_plan(&w, ROOMS);
    for (int i = 0; i < support_count(3000, 100000); i++) {
        body_check_stand(&w, random_between(&r, 0.3, 3.7), random_between(&r, 0.3, 3.7), 0);
        double angle = random_between(&r, 0, 2 * M_PI);
        body_step(&w.body, &w.world, vec2(5 * cos(angle), 5 * sin(angle)), 5);
        body_check_expect_free(&w, "after 5 m");
        cr_assert(w.body.foot.x < 4 && w.body.foot.z == 0, "it got to %g at %g", w.body.foot.x,
                  w.body.foot.z);
    }
    arena_free(&w.arena);
}

// Proves that it climbs the stairs of the house to the upper floor and comes down again, without leaving the treads:
// going down it is on something after every step.
Test(body, climbs_stairs_and_comes_down) {
    Walker w;
    body_check_open_file(&w, "build/maps/house.plan");
    body_check_stand(&w, 7.7, 1.1, 0);
    for (int i = 0; i < 250; i++) {
        body_step(&w.body, &w.world, vec2(0, 0.02), 1.0 / 60);
        body_check_expect_free(&w, "going up");
    }
    cr_assert_float_eq(w.body.foot.z, 2.9, 1e-9, "it came to %g m at y %g", w.body.foot.z, w.body.foot.y);
    for (int i = 0; i < 250; i++) {
        body_step(&w.body, &w.world, vec2(0, -0.02), 1.0 / 60);
        body_check_expect_free(&w, "going down");
        cr_assert(w.body.standing, "in the air at y %g, z %g", w.body.foot.y, w.body.foot.z);
    }
    cr_assert_float_eq(w.body.foot.z, 0, 1e-9, "it came to %g m", w.body.foot.z);
    // In one step too.
    body_step(&w.body, &w.world, vec2(0, 5), 0);
    cr_assert_float_eq(w.body.foot.z, 2.9, 1e-9, "in one step to %g m", w.body.foot.z);
    arena_free(&w.arena);
}

// Proves how high it steps, and that a rim does not help it higher: over a box of 0.35, not on one of 0.45, and not
// on a bed of 0.55 with a rim 4 cm wide 0.3 m high.
Test(body, steps_so_high_and_no_higher) {
    Walker w;
    body_check_open_plan(&w, ROOMS
                         "model low\n box 0,0,0 1,4,0.35 m\nend\nmodel high\n box 0,0,0 1,4,0.45 m\nend\n"
                         "model bed\n box 0,0,0 1,4,0.3 m\n box 0.04,0,0.3 1,4,0.55 m\nend\n"
                         "place low 1.5,0\nplace high 5.8,0\nplace bed 7,0\n");
    body_check_stand(&w, 0.5, 2, 0);
    go(&w, 1.5, 0, "on to the low box");
    cr_assert_float_eq(w.body.foot.z, 0.35, 1e-9);
    go(&w, 1.5, 0, "down again");
    cr_assert_eq(w.body.foot.z, 0);
    body_check_stand(&w, 4.9, 2, 0);
    body_check_expect_stop(&w, 1.5, 0, 0.7 - 1e-4, "the high box");
    arena_free(&w.arena);
    body_check_open_plan(&w, ROOMS
                         "model bed\n box 0,0,0 1,4,0.3 m\n box 0.04,0,0.3 1,4,0.55 m\nend\nplace bed 2,0\n");
    body_check_stand(&w, 1, 2, 0);
    body_step(&w.body, &w.world, vec2(2, 0), 0);
    cr_assert(w.body.foot.x < 2 && w.body.foot.z < 0.31, "it is on the bed, at %g m", w.body.foot.z);
    arena_free(&w.arena);
}

// Proves that it ducks under what leaves 1.2 m, stands up behind it, and is stopped by what hangs lower.
Test(body, ducks) {
    Walker w;
    body_check_open_plan(
        &w, ROOMS "model beam\n box 0,0,0 0.3,4,0.3 m\nend\nplace beam 1.5,0,1.25\nplace beam 6,0,1.15\n");
    body_check_stand(&w, 1, 2, 0);
    go(&w, 0.6, 0, "under the beam");
    cr_assert_float_eq(w.body.height, 1.25, 1e-9);
    cr_assert_float_eq(body_eye(&w.body), 1.25 - BODY_CROWN, 1e-9);
    go(&w, 1, 0, "behind it");
    cr_assert_float_eq(w.body.height, BODY_HEIGHT, 1e-9);
    cr_assert_float_eq(body_eye(&w.body), BODY_EYE, 1e-9);
    body_check_stand(&w, 5, 2, 0);
    body_check_expect_stop(&w, 2, 0, 1 - BODY_RADIUS - 1e-4, "the lower beam");
    arena_free(&w.arena);
}
