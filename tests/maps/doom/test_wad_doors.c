// test_wad_doors.c - doors and lifts of a Doom map.
#include <criterion/criterion.h>

#include "engine/sim/doors.h"
#include "engine/tour/tour.h"
#include "engine/walk/verify.h"
#include "tests/maps/doom/wad_fixture.h"
#include "tests/support/files/wad_builder.h"
#include "tests/support/support.h"

static int opening_named(const Building *b, const char *name) {
    for (int i = 0; i < b->opening_count; i++) {
        if (strcmp(b->openings[i].name, name) == 0) return i;
    }
    cr_assert_fail("there is no opening %s", name);
    return -1;
}

// ---- doors and lifts

// Proves that a closed door hides what is behind it and one that is hardly open hides nothing; that a lift never does.
Test(wad, doors_block_sight_and_lifts_do_not) {
    Made m;
    StabForest forest;
    wad_open_two_rooms(&m);
    VisOptions options = vis_default_options();
    cr_assert(vis_build_forest(&m.graph, &options, NULL, &m.arena, &forest));
    VisQuery *query = vis_query_new(&m.graph, &forest, &m.arena);
    int door = opening_named(&m.building, "door 1"), lift = opening_named(&m.building, "lift 3");
    Eye eye = {.position = vec3(200 * UNIT, 128 * UNIT, 1.6)};
    int cell = vis_locate(&m.graph, eye.position, -1),
        hall = (int)(wad_region_of(&m.building, WAD_HALL) - m.building.regions);
    for (int state = 0; state < 4; state++) {
        m.doors.open[door] = state % 2 ? 1e-6f : 0;
        m.doors.open[lift] = state / 2 ? 1 : 0;
        VisResult seen = vis_query(query, &eye, cell, m.doors.open, CULL_STAB);
        bool behind = false;
        for (int i = 0; i < seen.cell_count; i++)
            behind = behind || m.graph.cells[seen.cells[i].cell].region == hall;
        cr_expect_eq(behind, state % 2 == 1, "door %g, lift %g", (double)m.doors.open[door],
                     (double)m.doors.open[lift]);
    }
    int closing = 0;
    for (int i = 0; i < m.graph.portal_count; i++) {
        cr_expect(m.graph.portals[i].door != lift);
        closing += m.graph.portals[i].door == door;
    }
    cr_expect_eq(closing, 2, "the door closes its two sides");
    arena_free(&m.arena);
}

// Proves that culled pictures equal unculled ones, item for item, from random places with doors and lifts anywhere.
Test(wad, nothing_visible_is_lost) {
    Made m;
    StabForest forest;
    Error error;
    wad_open_two_rooms(&m);
    VisOptions options = vis_default_options();
    cr_assert(vis_build_forest(&m.graph, &options, NULL, &m.arena, &forest));
    WalkVerify *verify = walk_verify_new(&m.graph, &forest, &m.arena, &error);
    cr_assert(verify, "%s", error.text);
    uint64_t seed = 5;
    Random random = {seed};
    RandomView view = {.door_open = ARENA_ARRAY(&m.arena, float, m.building.opening_count)};
    int tried = 0;
    for (int i = 0; i < support_count(200, 4000); i++) {
        VerifyFrame frame;
        if (!walk_random_view(&m.graph, &random, 120, 80, &view)) continue;
        cr_assert(
            walk_verify_frame(verify, &view.camera, view.cell, view.door_open, CULL_STAB, &frame, &error),
            "%s", error.text);
        cr_expect(frame.missing_polygons == 0 && frame.mismatched_pixels == 0,
                  "seed %llu, view %d (%s): %d polygons missing, %d pixels differ", (unsigned long long)seed,
                  i, view.kind, frame.missing_polygons, frame.mismatched_pixels);
        tried++;
    }
    cr_expect_gt(tried, 50);
    walk_verify_free(verify);
    arena_free(&m.arena);
}

// Proves that a tour enters a room once, not once for each piece that it was cut into, and comes to the court, up a lift, by a cut.
Test(wad, tours_enter_each_room) {
    Made m;
    TourPath path;
    Error error;
    TourOptions options = tour_default_options();
    wad_open_two_rooms(&m);
    cr_assert(tour_make(&m.graph, "auto", &options, &m.arena, &path, &error), "%s", error.text);
    cr_expect_gt(m.building.region_count, 5, "no room is cut: this proves nothing");
    cr_expect_eq(path.rooms_enterable, 3, "%d rooms: the room, the hall and the court", path.rooms_enterable);
    cr_expect_eq(path.rooms_entered, 3);
    cr_expect_eq(path.cut_count, 1);
    arena_free(&m.arena);
}

static void walk_east(Made *m, double metres) {
    for (double gone = 0; gone < metres; gone += 0.02) body_step(&m->body, &m->world, vec2(0.02, 0), 0.02);
}

static void pass(Made *m, double seconds) {
    for (double t = 0; t < seconds; t += 1.0 / 120) {
        doors_advance(&m->doors, 1.0 / 120, &m->body);
        body_step(&m->body, &m->world, vec2(0, 0), 1.0 / 120);
    }
}

// Proves that a closed door holds a body and an open one lets it pass, and that one which comes down halts over a body
// in its doorway, and goes on when that has gone.
Test(wad, doors_hold_bodies_and_wait_for_them) {
    Made m;
    wad_open_two_rooms(&m);
    int door = opening_named(&m.building, "door 1");
    cr_assert(doors_usable(&m.doors, door));
    cr_assert(body_place_near(&m.body, &m.world, vec3(200 * UNIT, 128 * UNIT, 0)));
    walk_east(&m, 3);
    cr_expect_lt(m.body.foot.x, 256 * UNIT, "closed");
    Vec3 eye = vec3(m.body.foot.x, m.body.foot.y, 1.6);
    cr_expect_eq(doors_looked_at(&m.doors, eye, m.body.cell, vec3(1, 0, 0), DOORS_REACH), door);
    cr_expect_eq(doors_looked_at(&m.doors, eye, m.body.cell, vec3(-1, 0, 0), DOORS_REACH), -1);
    cr_assert(doors_toggle(&m.doors, door));
    pass(&m, 0.3);
    cr_expect(m.doors.open[door] > 0 && m.doors.open[door] < 1, "it takes its time");
    pass(&m, 2);
    cr_expect_eq(m.doors.open[door], 1.0f);
    walk_east(&m, 264 * UNIT - m.body.foot.x);
    cr_assert(fabs(m.body.foot.x - 264 * UNIT) < 0.1, "in the doorway");
    doors_toggle(&m.doors, door);
    pass(&m, 3);
    cr_expect_gt(m.doors.open[door], 0.3f, "it does not come down on a body");
    cr_expect_eq(m.doors.halt[door], DOOR_MEETS_BODY);
    walk_east(&m, 2);
    pass(&m, 3);
    cr_expect_gt(m.body.foot.x, 272 * UNIT);
    cr_expect_eq(m.doors.open[door], 0.0f);
    cr_expect_eq(m.world.relocations, 0);
    arena_free(&m.arena);
}

// Proves that a lift carries who stands on it, down and up again, and stops nobody walking off.
Test(wad, lifts_carry_bodies) {
    Made m;
    wad_open_two_rooms(&m);
    int lift = opening_named(&m.building, "lift 3");
    double top = 64 * UNIT;
    cr_assert(body_place_near(&m.body, &m.world, vec3(560 * UNIT, 128 * UNIT, top)));
    cr_expect_float_eq(m.body.foot.z, top, 1e-6, "it stands up as drawn");
    cr_assert(doors_toggle(&m.doors, lift));
    pass(&m, 3);
    cr_expect_eq(m.doors.open[lift], 1.0f);
    cr_expect_float_eq(m.body.foot.z, 0, 1e-6, "down");
    doors_toggle(&m.doors, lift);
    pass(&m, 3);
    cr_expect_eq(m.doors.open[lift], 0.0f);
    cr_expect_float_eq(m.body.foot.z, top, 1e-6, "up");
    cr_expect_float_eq(m.body.foot.x, 560 * UNIT, 1e-3, "where it was");
    cr_expect_eq(m.world.relocations, 0);
    walk_east(&m, 3);
    cr_expect_gt(m.body.foot.x, 592 * UNIT + 1, "into the court");
    arena_free(&m.arena);
}

// A lift of 64 x 64 units that goes down into a hall, with so much room over it when it is up. It lies to the east, so that
// its cell is the first.
static void open_lift(Made *m, int room) {
    static const int AT[][8] = {
        {0, 0, 0, 64, 0, -1, 0, 0},        {0, 64, 64, 64, 0, -1, 0, 0},     {64, 64, 64, 0, 0, 1, 62, 5},
        {64, 0, 0, 0, 0, -1, 0, 0},        {64, 64, 64, 160, 1, -1, 0, 0},   {64, 160, 320, 160, 1, -1, 0, 0},
        {320, 160, 320, -96, 1, -1, 0, 0}, {320, -96, 64, -96, 1, -1, 0, 0}, {64, -96, 64, 0, 1, -1, 0, 0}};
    *m = (Made){.arena = {0}};
    WadMaker maker = {.arena = &m->arena};
    wad_sector(&maker, 64, 64 + room, "CEIL", 5);
    wad_sector(&maker, 0, 200, "CEIL", 0);
    for (size_t i = 0; i < sizeof AT / sizeof *AT; i++) {
        const int *l = AT[i];
        wad_line(&maker, 320 - l[0], 64 - l[1], 320 - l[2], 64 - l[3], l[4], l[5], l[6], l[7]);
    }
    wad_thing(&maker, 120, 32, 0, 1);
    wad_open_file(m, wad_write_map(&m->arena, &maker));
}

// Proves that whoever a lift carries stands on its top at each moment, no taller than there is room under the ceiling, and that it halts
// before it presses anybody: with room to stand, to duck, and with too little. Nothing but the lift moves the body.
Test(wad, lifts_press_nobody) {
    static const int ROOMS[] = {100, 50, 41, 36, 20};
    for (size_t k = 0; k < sizeof ROOMS / sizeof *ROOMS; k++) {
        Made m;
        open_lift(&m, ROOMS[k]);
        int lift = opening_named(&m.building, "lift 0");
        double ceiling = (64 + ROOMS[k]) * UNIT, highest = ceiling - BODY_LOWEST;
        doors_set(&m.doors, lift, 1);
        cr_assert(body_place_near(&m.body, &m.world, vec3(288 * UNIT, 32 * UNIT, 0)));
        cr_assert_float_eq(m.body.foot.z, 0, 1e-6);
        cr_assert_eq(m.body.cell, 0, "the first cell is that of the lift");
        doors_toggle(&m.doors, lift);
        for (int i = 0; i < 400; i++) {
            doors_advance(&m.doors, 1.0 / 240, &m.body);
            const Leaf *leaf = &m.building.leaves[m.building.openings[lift].first_leaf];
            // Wide open it lies a hair under the floor.
            double top = fmax(0, leaf->z1 + (double)m.doors.open[lift] * leaf->rise);
            cr_assert_float_eq(m.body.foot.z, top, 2e-6, "room of %d: at %g on a lift at %g", ROOMS[k],
                               m.body.foot.z, top);
            cr_assert(m.body.standing && m.body.fall == 0);
            cr_assert_float_eq(m.body.height, fmin(BODY_HEIGHT, ceiling - top), 1e-5);
            cr_assert_float_eq(m.body.head, fmin(BODY_HEIGHT, ceiling - top), 1e-5);
        }
        bool up = highest >= 64 * UNIT;
        cr_expect_eq(m.doors.open[lift] == 0, up, "room of %d: at %g", ROOMS[k], (double)m.doors.open[lift]);
        cr_expect_eq(m.doors.halt[lift], up ? DOOR_FREE : DOOR_MEETS_BODY);
        // A step of a leaf is a centimetre.
        if (!up) cr_expect(m.body.foot.z > highest - 0.011 && m.body.foot.z <= highest + 1e-6);
        arena_free(&m.arena);
    }
}

// Puts 16 bits into a record of the small map.
static void poke(unsigned char *records, int at, int value) {
    records[at] = (unsigned char)(value & 255);
    records[at + 1] = (unsigned char)(value >> 8 & 255);
}

typedef struct Motion {
    int door_special, floor, ceiling;  // of the door's lines; of its sector
    int lift_special;
    double z0, z1, open, lift_z0;  // of the regions, map units; of the door as drawn
    bool sinks;
} Motion;

// Proves which sectors are doors and lifts, and how far they go: by hand and by tag, Boom's specials, closed without any,
// drawn ajar or open, and where only the floor has somewhere to go.
Test(wad, what_moves) {
    static const Motion MOTIONS[] = {
        {1, 0, 0, 62, 0, 124, 0, 0, false},       {0, 0, 0, 88, 0, 124, 0, 0, false},
        {117, 0, 31, 0, 0, 124, 0.25, 64, false}, {0x3C07, 0, 62, 0x3400, 0, 124, 0.5, 0, false},
        {1, 0, 128, 0, 0, 128, 1, 64, false},     {0, 40, 40, 0, 40, 124, 0, 64, false},
        {0, 128, 128, 123, 0, 128, 0, 0, true},
    };
    enum { LINE = 14, SECTOR = 26, FRONT_OF_DOOR = 3, BACK_OF_DOOR = 13, FRONT_OF_LIFT = 17 };
    for (size_t i = 0; i < sizeof MOTIONS / sizeof *MOTIONS; i++) {
        const Motion *x = &MOTIONS[i];
        Made m = {.arena = {0}};
        WadMaker maker = {.arena = &m.arena};
        wad_two_rooms(&maker);
        poke(maker.lines, LINE * FRONT_OF_DOOR + 6, x->door_special);
        poke(maker.lines, LINE * BACK_OF_DOOR + 6, x->door_special);
        poke(maker.lines, LINE * FRONT_OF_LIFT + 6, x->lift_special);
        poke(maker.sectors, SECTOR * WAD_DOOR_SECTOR, x->floor);
        poke(maker.sectors, SECTOR * WAD_DOOR_SECTOR + 2, x->ceiling);
        wad_open_file(&m, wad_write_map(&m.arena, &maker));
        const Region *door = wad_region_of(&m.building, WAD_DOOR_SECTOR),
                     *lift = wad_region_of(&m.building, WAD_LIFT_SECTOR);
        const Opening *opening = &m.building.openings[opening_named(&m.building, "door 1")];
        cr_expect_float_eq(door->z0, x->z0 * UNIT, 1e-12, "case %zu", i);
        cr_expect_float_eq(door->z1, x->z1 * UNIT, 1e-12, "case %zu", i);
        cr_expect_float_eq(opening->open, x->open, 1e-12, "case %zu", i);
        cr_expect_eq(m.building.leaves[opening->first_leaf].rise < 0, x->sinks, "case %zu", i);
        cr_expect_float_eq(lift->z0, x->lift_z0 * UNIT, 1e-12, "case %zu", i);
        cr_expect_eq(m.building.opening_count, x->lift_z0 == 0 ? 2 : 1, "case %zu", i);
        arena_free(&m.arena);
    }
}

// Proves where a rising leaf is: it keeps its plan, its height goes with its share, and it is found in the squares of
// every cell that it passes.
Test(wad, leaves_rise) {
    Leaf leaf = {.rise = 2.5, .axis = {{0, 0}, {1, 0}}, .thickness = 0.2, .z1 = 2};
    cr_expect(vec3_equal(leaf_point(&leaf, 0.5, vec3(0.3, 0.1, 1)), vec3(0.3, 0.1, 2.25)));
    Made m;
    wad_open_two_rooms(&m);
    const CellGraph *g = &m.graph;
    const char *fault = "";
    m.building.leaves[0].corner_count = 2;
    cr_expect(building_check(&m.building, &m.arena, &fault, 1) == 1 && strstr(fault, "leaf 0: corners"), "%s",
              fault);
    m.building.leaves[0].corner_count = 4;
    for (int o = 0; o < m.building.object_count; o++) {
        if (g->objects[o].leaf < 0) continue;
        const Leaf *l = &m.building.leaves[g->objects[o].leaf];
        Vec2 corner[LEAF_CORNERS];
        cr_assert_eq(leaf_plan(&m.building, l, 0.7, corner), 4);
        Box box = g->object_boxes[o];
        cr_expect_leq(box.min.z, l->z0 + fmin(0, l->rise));
        cr_expect_geq(box.max.z, l->z1 + fmax(0, l->rise));
        for (int i = 0; i < 4; i++) cr_expect(box_contains(box, vec3(corner[i].x, corner[i].y, l->z0)));
    }
    arena_free(&m.arena);
}
