// test_body_falls.c - bodies in furniture, falls, door frames, and places without room.
#include <criterion/criterion.h>

#include "engine/sim/door_part.h"
#include "engine/sim/doors.h"
#include "maps/maps.h"
#include "tests/sim/body_fixture.h"
#include "tests/support/fixture.h"
#include "tests/support/support.h"

// Proves that what it is put into does not hold it: it stands free, in the same room.
Test(body, inside_furniture) {
    Walker w;
    Random r = {41};
    body_check_open_plan(&w, ROOMS "model block\n box -0.8,-0.8,0 0.8,0.8,1 m\nend\nplace block 3,2\n");
    for (int i = 0; i < 200; i++) {
        Vec3 at =
            vec3(3 + random_between(&r, -1, 1), 2 + random_between(&r, -1, 1), random_between(&r, -0.2, 1.2));
        cr_assert(body_place_near(&w.body, &w.world, at));
        body_check_expect_free(&w, "put in a block");
        cr_assert(w.body.foot.x < 4 && w.body.foot.z < 1.01, "it got to %g, %g", w.body.foot.x,
                  w.body.foot.z);
    }
    w.body.foot = vec3(3, 2, 0);
    body_step(&w.body, &w.world, vec2(0.01, 0), 0);
    cr_assert_eq(w.world.relocations, 1);
    w.world.relocations = 0;
    body_check_expect_free(&w, "reloaded in a block");
    arena_free(&w.arena);
}

// Proves that it falls off an edge, faster and faster, and lands; also when the machine stalls for 5 s in the air.
Test(body, falls) {
    static const double TICKS[2] = {1.0 / 60, 5};
    Walker w;
    body_check_open_plan(&w, ROOMS "model block\n box 0,0,0 1,4,1.2 m\nend\nplace block 1,0\n");
    for (int k = 0; k < 2; k++) {
        body_check_stand(&w, 1.5, 2, 1.3);
        cr_assert_float_eq(w.body.foot.z, 1.2, 1e-9);
        body_step(&w.body, &w.world, vec2(0.9, 0), TICKS[0]);
        cr_assert(!w.body.standing && w.body.foot.z > 1.19 && w.body.foot.z < 1.2);
        int ticks = 0;
        for (; !w.body.standing && ticks < 100; ticks++) {
            body_step(&w.body, &w.world, vec2(0, 0), TICKS[k]);
            body_check_expect_free(&w, "falling");
        }
        cr_assert(w.body.foot.z == 0 && w.body.fall == 0);
        // A fall of 1.2 m takes sqrt(2 * 1.2 / 9.81) = 0.495 s, less the tick that began it.
        if (k == 0) cr_assert(ticks >= 28 && ticks <= 30, "it fell for %d ticks", ticks);
    }
    arena_free(&w.arena);
}

// Proves that a long fall follows g t^2 / 2 until 50 m/s are reached, and goes on at that speed: by small ticks, and by such as a
// stalled machine has.
Test(body, falls_no_faster_than_in_air) {
    static const double TICKS[2] = {1.0 / 60, 5};
    Walker w;
    body_check_open_plan(
        &w, "plan 1\nmaterial m #808080\nstorey s floor 0 height 900\nroom a 0,0 4,0 4,4 0,4 wall 0.2\n");
    for (int k = 0; k < 2; k++) {
        body_check_stand(&w, 2, 2, 0);
        w.body.foot.z = 880;
        w.body.standing = false;
        double t = 0, reached = 50 / 9.81;
        for (int i = 0; t < 14.9; i++) {
            double before = w.body.foot.z;
            body_step(&w.body, &w.world, vec2(0, 0), TICKS[k]);
            t += TICKS[k];
            double fallen = t < reached ? 9.81 * t * t / 2 : 25 * reached + 50 * (t - reached);
            cr_assert_leq(before - w.body.foot.z, 50 * TICKS[k] + 1e-9, "tick %d of %g s", i, TICKS[k]);
            // The tick in which the speed is reached: half of the speed that it would gain.
            cr_assert_float_eq(880 - w.body.foot.z, fallen, 9.81 * TICKS[k] * TICKS[k], "after %g s", t);
        }
    }
    arena_free(&w.arena);
}

// A box that is part of an opening, and of one of its leaves if that is not below 0.
typedef struct Part {
    ObjectKind kind;
    int opening, leaf;
    double x0, y0, z0, x1, y1, z1;
} Part;

static void add_part(Walker *w, const Part *p) {
    Building *b = &w->building;
    int object = building_add_object(&w->arena, b, p->kind, "part");
    b->objects[object].opening = p->opening;
    b->objects[object].leaf = p->leaf;
    const Vec2 c[4] = {{p->x0, p->y0}, {p->x1, p->y0}, {p->x1, p->y1}, {p->x0, p->y1}};
    Vec3 top[4], foot[4];
    for (int i = 0; i < 4; i++) {
        Vec2 a = c[i], e = c[(i + 1) % 4];
        Vec3 side[4] = {vec3(a.x, a.y, p->z0), vec3(e.x, e.y, p->z0), vec3(e.x, e.y, p->z1),
                        vec3(a.x, a.y, p->z1)};
        building_add_polygon(&w->arena, b, side, 4, 0);
        top[i] = vec3(a.x, a.y, p->z1);
        foot[3 - i] = vec3(a.x, a.y, p->z0);
    }
    building_add_polygon(&w->arena, b, top, 4, 0);
    building_add_polygon(&w->arena, b, foot, 4, 0);
}

// Proves what frames stop: posts are felt like all that is drawn; a frame which alone bars its door, as a threshold board at the height
// of a chest does, is not, while it is of furniture, of a passage, or where the door would let nobody pass without it. What moves with
// a leaf or is of another door bars nothing.
Test(door_frames, are_felt_or_not) {
    enum { DOOR, NARROW, PASSAGE };
    static const struct {
        Part part;
        int door;
        bool with, without;  // does it let pass?
        bool passes;         // does a body?
    } CASES[] = {
        // Nothing; posts at either jamb; a board across; the same over the head, and to step over.
        {{OBJECT_FRAME, DOOR, -1, 3, 0.5, 0, 3.1, 0.6, 1}, DOOR, true, true, true},
        {{OBJECT_FRAME, DOOR, -1, 3.9, 1.4, 0, 4.3, 1.55, 2}, DOOR, true, true, true},
        {{OBJECT_FRAME, DOOR, -1, 3.9, 2.5, 0, 4.3, 2.6, 2}, DOOR, true, true, true},
        {{OBJECT_FRAME, DOOR, -1, 4.05, 1.3, 0.7, 4.15, 2.7, 0.9}, DOOR, false, true, true},
        {{OBJECT_FRAME, DOOR, -1, 4.05, 1.3, 1.9, 4.15, 2.7, 2}, DOOR, true, true, true},
        {{OBJECT_FRAME, DOOR, -1, 4.05, 1.3, 0, 4.15, 2.7, 0.1}, DOOR, true, true, true},
        // The board as furniture, of nothing, of another door, of a leaf.
        {{OBJECT_FURNITURE, DOOR, -1, 4.05, 1.3, 0.7, 4.15, 2.7, 0.9}, DOOR, true, true, false},
        {{OBJECT_FRAME, -1, -1, 4.05, 1.3, 0.7, 4.15, 2.7, 0.9}, DOOR, true, true, false},
        {{OBJECT_FRAME, NARROW, -1, 4.05, 1.3, 0.7, 4.15, 2.7, 0.9}, DOOR, true, true, false},
        {{OBJECT_FRAME, DOOR, 0, 4.05, 1.3, 0.7, 4.15, 2.7, 0.9}, DOOR, true, true, true},
        // The frame of a door that is too narrow without it; of a passage.
        {{OBJECT_FRAME, NARROW, -1, 4.05, 3.2, 0.7, 4.15, 3.7, 0.9}, NARROW, false, false, false},
        {{OBJECT_FRAME, PASSAGE, -1, 4.05, 0.2, 0.7, 4.15, 1.1, 0.9}, PASSAGE, false, true, false},
    };
    static const double MIDDLE[] = {2, 3.45, 0.65};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        const Part *p = &CASES[i].part;
        Walker w = {.arena = {0}};
        Error error;
        char *path = arena_format(&w.arena, "%s/test.plan", support_folder(&w.arena));
        static const char PLAN[] =
            ROOMS "door d 4.1,2 angle 90 width 1.2 height 2.1 hinge left swing 88\n"
                  "door n 4.1,3.45 angle 90 width 0.35 height 2.1 hinge left swing 88\n"
                  "passage p 4.1,0.65 angle 90 width 0.9 height 2.1\n";
        cr_assert(file_write(path, PLAN, sizeof PLAN - 1, &error), "%s", error.text);
        cr_assert(maps_read(path, &w.arena, &w.building, &error), "%s", error.text);
        add_part(&w, p);
        body_check_open_cells(&w);
        for (int o = 0; o < w.building.opening_count; o++) doors_set(&w.doors, o, 1);
        cr_expect_eq(door_lets_pass(&w.graph, CASES[i].door, true), CASES[i].with, "case %zu, with its frame",
                     i);
        cr_expect_eq(door_lets_pass(&w.graph, CASES[i].door, false), CASES[i].without, "case %zu, without",
                     i);
        for (int y = -3; y <= 3; y++) {
            body_check_stand(&w, 2, MIDDLE[CASES[i].door], 0);
            body_step(&w.body, &w.world, vec2(1.2, 0.1 * y), 0.1);
            for (int k = 0; k < 300; k++) {
                body_step(&w.body, &w.world, vec2(0.01, 0), 0.01);
                double dx = fmax(fmax(p->x0 - w.body.foot.x, w.body.foot.x - p->x1), 0),
                       dy = fmax(fmax(p->y0 - w.body.foot.y, w.body.foot.y - p->y1), 0);
                bool felt = p->leaf < 0 &&
                            (CASES[i].with || !CASES[i].without || p->kind != OBJECT_FRAME ||
                             p->opening == PASSAGE) &&
                            p->z1 > w.body.foot.z + 1e-9 && p->z0 < w.body.foot.z + w.body.height - 1e-9;
                cr_assert(!felt || hypot(dx, dy) > BODY_RADIUS - BODY_TOLERANCE,
                          "case %zu: a body at %g, %g, %g is in it", i, w.body.foot.x, w.body.foot.y,
                          w.body.foot.z);
            }
            if (y == 0)
                cr_expect_eq(w.body.foot.x > 4.5, CASES[i].passes, "case %zu: it comes to %g", i,
                             w.body.foot.x);
        }
        arena_free(&w.arena);
    }
}

// Proves that a body which has no place yet is put near where it is wanted before it goes on, and stays without where there is none.
Test(body, without_a_place) {
    Walker w;
    body_check_open_plan(&w, ROOMS "passage p 4.1,2 angle 90 width 1.2 height 2.1\n");
    w.body.foot = vec3(3, 1, 0);
    body_step(&w.body, &w.world, vec2(0.5, 0), 0.05);
    cr_expect_eq(w.world.relocations, 1);
    cr_assert_geq(w.body.cell, 0);
    cr_expect(fabs(w.body.foot.x - 3.5) < 1e-3 && w.body.foot.y == 1, "it comes to %g, %g", w.body.foot.x,
              w.body.foot.y);
    w.body = (Body){.foot = {500, 1, 0}, .cell = -1};
    body_step(&w.body, &w.world, vec2(0.5, 0), 0.05);
    cr_expect(w.body.cell == -1 && w.body.foot.x == 500);
    arena_free(&w.arena);
}

// Proves that a window is no way out, though nothing is drawn in it.
Test(body, does_not_climb_out_of_windows) {
    Walker w;
    body_check_open_plan(&w, ROOMS "ground m\nwindow w 2,-0.1 width 2 sill 0.3 height 2\n");
    body_check_stand(&w, 2, 1, 0);
    body_check_expect_stop(&w, 0, -2, 1 - BODY_RADIUS - 1e-4, "the window");
    arena_free(&w.arena);
}
