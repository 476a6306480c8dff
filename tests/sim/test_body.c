// test_body.c - the walking body is never in anything solid, and loses no place that can be reached by foot.
#include <criterion/criterion.h>

#include "engine/sim/collision_check.h"
#include "engine/sim/collision_walk.h"
#include "engine/sim/doors.h"
#include "maps/maps.h"
#include "tests/sim/body_fixture.h"
#include "tests/support/support.h"

// ---- whole buildings

// A random walk with doors moving, every place and every way checked against all polygons; and the ways of a flood of
// the floor, walked. `steps` at `make test`.
static void expect_no_fault(const char *path, long steps, int flood_every) {
    enum { SEEDS = 4 };
    Walker w = {.arena = {0}};
    Error error;
    VisOptions options = vis_default_options();
    cr_assert(maps_read(path, &w.arena, &w.building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&w.building, &options, &w.arena, &w.graph, &error), "%s", error.text);
    int seeds = support_soak() ? SEEDS : 1;
    for (int seed = 1; seed <= seeds; seed++) {
        CollisionWalkOptions o = {support_soak() ? 1000000 / SEEDS : steps, (uint64_t)seed,
                                  support_soak() ? 1 : flood_every};
        CollisionReport r;
        cr_assert(collision_walk(&w.graph, &o, &r, &error), "%s", error.text);
        cr_assert_eq(collision_violations(&r), 0, "%s: %ld violations, the first: %s", path,
                     collision_violations(&r), r.first_fault);
        cr_assert_eq(r.flood_lost, 0, "%s: %ld of %ld ways of the flood lost, the first: %s", path,
                     r.flood_lost, r.flood_ways, r.first_lost);
        cr_assert_eq(r.relocations, 0, "%s: put elsewhere %ld times", path, r.relocations);
        cr_assert_eq(r.stuck, 0, "%s: stuck %ld times", path, r.stuck);
        // A leaf may shut it in a corner, until that door is used or the body put elsewhere: some hundred steps each time.
        cr_assert_leq(r.shut_in, r.steps / 100, "%s: shut in %ld times", path, r.shut_in);
        cr_assert_gt(r.flood_places, 1000);
    }
    arena_free(&w.arena);
}

Test(body, two_rooms, .timeout = 1800) { expect_no_fault("build/maps/two-rooms.plan", 50000, 7); }

Test(body, house, .timeout = 1800) { expect_no_fault("build/maps/house.plan", 40000, 41); }

Test(body, office, .timeout = 3600) { expect_no_fault("build/maps/office-plain.plan", 40000, 97); }

Test(body, home_with_basement, .timeout = 1800) {
    expect_no_fault(support_either("sh3d/2BedroomHouseWithBasement.Home.xml", "build/maps/hillside.sh3d"),
                    40000, 41);
}

Test(body, apartment, .timeout = 1800) {
    expect_no_fault(support_either("sh3d/3BedroomApartment.Home.xml", "build/maps/flat.Home.xml"), 40000, 41);
}

Test(body, four_bedrooms, .timeout = 3600) {
    expect_no_fault(support_either("sh3d/4-BedroomHouse.sh3d", "build/maps/villa.sh3d"), 20000, 197);
}

// Polygons alone, with a roof to stand on as far as the border of the world, which runs along the outer walls.
Test(body, two_rooms_of_polygons, .timeout = 1800) {
    expect_no_fault(support_either("radiosity/twoRoom.quads", "tests/seeds/two-rooms.quads"), 20000, 1);
}

Test(body, box_of_polygons, .timeout = 1800) {
    expect_no_fault(support_either("radiosity/boxA.quads", "tests/seeds/boxes.quads"), 20000, 1);
}

// Proves that the check above can fail: a body that is moved into a wall, through a wall and into a leaf is noticed.
Test(body, check_notices) {
    Walker w;
    int what;
    body_check_open_file(&w, "build/maps/two-rooms.plan");
    body_check_stand(&w, 0.8, 0.8, 0);
    Vec3 foot = w.body.foot, outside = {-0.5, foot.y, foot.z}, wall = {0.1, foot.y, foot.z};
    cr_assert_eq(collision_check_place(w.check, NULL, foot, 1.7, &what), COLLISION_NONE);
    cr_assert_eq(collision_check_place(w.check, NULL, wall, 1.7, &what), COLLISION_IN_SOLID);
    cr_assert_eq(collision_check_way(w.check, NULL, foot, outside, &what), COLLISION_THROUGH_SOLID);
    const Opening *door = &w.building.openings[0];
    cr_assert_eq(door->kind, OPENING_DOOR);
    Vec2 middle = vec2_scale(vec2_add(door->line[0], door->line[1]), 0.5);
    Vec2 half = vec2_scale(vec2_sub(door->line[1], door->line[0]), 0.5);
    Vec3 in = {middle.x, middle.y, door->sill}, before = {in.x + half.y, in.y - half.x, in.z},
         behind = {in.x - half.y, in.y + half.x, in.z};
    cr_assert_eq(collision_check_place(w.check, NULL, in, 1.7, &what), COLLISION_NONE);
    doors_set(&w.doors, 0, 0);
    cr_assert_eq(collision_check_place(w.check, w.doors.open, in, 1.7, &what), COLLISION_IN_LEAF);
    cr_assert_eq(collision_check_way(w.check, w.doors.open, before, behind, &what), COLLISION_THROUGH_LEAF);
    arena_free(&w.arena);
}

// Proves that the same seed walks the same way to the last bit, and another one another way.
Test(body, walks_the_same_way_again) {
    Walker w;
    uint64_t hash[3];
    body_check_open_file(&w, "build/maps/two-rooms.plan");
    for (int i = 0; i < 3; i++) {
        CollisionWalkOptions o = {2000, i == 2 ? 6 : 5, 1000};
        CollisionReport r;
        Error error;
        cr_assert(collision_walk(&w.graph, &o, &r, &error), "%s", error.text);
        hash[i] = r.hash;
    }
    cr_assert(hash[0] == hash[1] && hash[0] != hash[2]);
    arena_free(&w.arena);
}
