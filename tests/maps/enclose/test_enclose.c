// test_enclose.c - free space from drawn plans: the cases that break a naive reader, one by one.
#include <criterion/criterion.h>
#include <math.h>

#include "tests/support/draft_fixture.h"
#include "tests/support/support.h"

// Proves that four walls and a room give one region of exactly the room's area, with the sides' materials,
// and that the walk starts inside it.
Test(enclose, one_room) {
    Draft d = draft_new(1);
    draft_box_walls(&d, 0, 0, 0, 4, 3);
    draft_room(&d, 0, 0, 0, 4, 3);
    draft_enclose(&d);
    cr_expect_eq(draft_count_kind(&d, REGION_ROOM), 1);
    cr_expect_float_eq(draft_area_of(&d, REGION_ROOM), 12, 1e-9);
    cr_expect_float_eq(d.b.drawn_area, 12, 1e-9);
    cr_expect_float_eq(d.b.lost_area, 0, 1e-9);
    cr_expect_eq(d.b.note_count, 0);
    cr_expect_eq(draft_kind_at(&d, d.b.start.x, d.b.start.y, d.b.start.z), REGION_ROOM);
    for (int i = 0; i < d.b.region_count; i++) {
        const Region *r = &d.b.regions[i];
        if (r->kind != REGION_ROOM) continue;
        cr_expect_eq(d.b.rings[r->first_ring].point_count, 4);
        cr_expect_eq(d.b.edge_material[d.b.rings[r->first_ring].first_point], 3);
        cr_expect_eq(r->floor_material, 1);
    }
    cr_expect_eq(draft_kind_at(&d, 2, 1, 2.6), -1, "the roof is solid");
    cr_expect_eq(draft_kind_at(&d, 2, 1, 3), -1, "nothing opens to the sky over the roof: it is left out");
    cr_expect_eq(draft_kind_at(&d, 2, 1, -0.1), -1, "the slab is solid");
    draft_free(&d);
}

// Walls between two rooms of 4 x 3 and 3 x 3 m; the door's depth is 0.6 (a model drawn ajar), its wall 0.2.
static void draw_two_rooms(Draft *d) {
    draft_box_walls(d, 0, 0, 0, 7.2, 3);
    draft_wall(d, 0, 4.1, 0, 4.1, 3, DRAFT_WALL, DRAFT_HEIGHT);
    draft_room(d, 0, 0, 0, 4, 3);
    draft_room(d, 0, 4.2, 0, 7.2, 3);
    draft_opening(d, OPENING_DOOR, 0, 4.1, 1.5, M_PI / 2, 0.9, 0.6);
    draft_opening(d, OPENING_DOOR, 0, 2, -0.1, 0, 0.9, 0.05);
    draft_opening(d, OPENING_WINDOW, 0, 7.3, 1.5, M_PI / 2, 1.2, 0.05);
}

// Proves that doors are cut through their wall alone, in two halves, join what lies on either side, in the
// order of left and right of the leaf, and get a leaf that hangs on one end; a window is one region.
Test(enclose, two_rooms_and_doors) {
    Draft d = draft_new(1);
    draw_two_rooms(&d);
    draft_enclose(&d);
    cr_expect_eq(draft_count_kind(&d, REGION_ROOM), 2);
    cr_expect_eq(draft_count_kind(&d, REGION_OPENING), 5);
    cr_expect(draft_joins(&d, 0, REGION_ROOM, REGION_ROOM));
    cr_expect(draft_joins(&d, 1, REGION_ROOM, REGION_OUTDOORS));
    cr_expect(draft_joins(&d, 2, REGION_ROOM, REGION_OUTDOORS));
    cr_expect_float_eq(draft_area_of(&d, REGION_OPENING), 0.2 * (0.9 + 0.9 + 1.2), 1e-9);
    const Opening *o = &d.b.openings[0];
    // The leaf runs along +y, so its left is the western room.
    cr_expect_str_eq(d.b.regions[o->region[0]].name, "Room 0");
    cr_expect_str_eq(d.b.regions[o->region[1]].name, "Room 1");
    cr_expect_float_eq(o->line[0].x, 4.1, 1e-9);
    cr_expect_float_eq(o->line[0].y, 1.05, 1e-9);
    cr_expect_eq(o->reason, NULL);
    int leaves = 0;
    for (int i = 0; i < d.b.object_count; i++) {
        const Object *object = &d.b.objects[i];
        if (object->kind != OBJECT_LEAF) continue;
        leaves++;
        cr_expect_eq(object->leaf, leaves - 1);
        cr_expect_eq(object->polygon_count, 6);
    }
    cr_expect_eq(leaves, 2);
    cr_expect_eq(draft_kind_at(&d, 4.1, 1.5, 2.2), -1, "above the door is wall");
    cr_expect_eq(draft_kind_at(&d, 7.3, 1.5, 0.5), -1, "below the window is wall");
    draft_free(&d);
}

// Proves that a turned and shifted copy is the same building: counts, joins and areas. Tolerance of areas:
// the grid moves each of the outlines by at most 1 mm over some 10 m.
Test(enclose, turned_and_shifted) {
    Draft plain = draft_new(1);
    draw_two_rooms(&plain);
    draft_enclose(&plain);
    for (int i = 1; i < 4; i++) {
        Draft d = draft_new(1);
        d.turn = i & 1 ? 17 * M_PI / 180 : 0;
        d.shift = i & 2 ? vec2(1e6, -1e6) : vec2(0, 0);
        draw_two_rooms(&d);
        draft_enclose(&d);
        for (int k = 0; k < REGION_KINDS; k++) {
            cr_expect_eq(draft_count_kind(&d, (RegionKind)k), draft_count_kind(&plain, (RegionKind)k),
                         "case %d kind %d", i, k);
            if (k != REGION_OUTDOORS)
                cr_expect_float_eq(draft_area_of(&d, (RegionKind)k), draft_area_of(&plain, (RegionKind)k),
                                   0.02);
        }
        cr_expect(draft_joins(&d, 0, REGION_ROOM, REGION_ROOM));
        cr_expect(draft_joins(&d, 1, REGION_ROOM, REGION_OUTDOORS));
        cr_expect_eq(d.b.note_count, plain.b.note_count);
        draft_free(&d);
    }
    draft_free(&plain);
}

// Proves that a building shifted by 1,000 km is the same to the millimetre.
Test(enclose, shifted_exactly) {
    Draft a = draft_new(1), b = draft_new(1);
    a.turn = b.turn = 0.3;
    b.shift = vec2(1e6, 2e6);
    draw_two_rooms(&a);
    draw_two_rooms(&b);
    draft_enclose(&a);
    draft_enclose(&b);
    cr_assert_eq(a.b.point_count, b.b.point_count);
    for (int i = 0; i < a.b.point_count; i++) {
        cr_assert_float_eq(a.b.points[i].x + 1e6, b.b.points[i].x, 1e-6);
        cr_assert_float_eq(a.b.points[i].y + 2e6, b.b.points[i].y, 1e-6);
    }
    draft_free(&a);
    draft_free(&b);
}

// Proves that a door closes the gap between two walls that it stands in, leaving slits of 1 cm on either
// side.
Test(enclose, door_in_a_gap) {
    Draft d = draft_new(1);
    draft_box_walls(&d, 0, 0, 0, 7.2, 3);
    draft_wall(&d, 0, 4.1, 0, 4.1, 1, DRAFT_WALL, DRAFT_HEIGHT);
    draft_wall(&d, 0, 4.1, 2, 4.1, 3, DRAFT_WALL, DRAFT_HEIGHT);
    draft_room(&d, 0, 0, 0, 4, 3);
    draft_room(&d, 0, 4.2, 0, 7.2, 3);
    draft_opening(&d, OPENING_DOOR, 0, 4.1, 1.5, M_PI / 2, 0.98, 0.2);
    draft_enclose(&d);
    cr_expect_eq(draft_count_kind(&d, REGION_ROOM), 2);
    cr_expect(draft_joins(&d, 0, REGION_ROOM, REGION_ROOM));
    cr_expect_eq(draft_kind_at(&d, 4.1, 1.5, 2.2), -1, "above the door is wall");
    draft_free(&d);
}

// Proves that an outer door in a gap, 1 cm too narrow on either side, does not let the room leak: the slits
// are closed.
Test(enclose, slits_beside_a_door) {
    Draft d = draft_new(1);
    double h = DRAFT_WALL / 2;
    draft_wall(&d, 0, -DRAFT_WALL, 3 + h, 4 + DRAFT_WALL, 3 + h, DRAFT_WALL, DRAFT_HEIGHT);
    draft_wall(&d, 0, -h, -DRAFT_WALL, -h, 3 + DRAFT_WALL, DRAFT_WALL, DRAFT_HEIGHT);
    draft_wall(&d, 0, 4 + h, -DRAFT_WALL, 4 + h, 3 + DRAFT_WALL, DRAFT_WALL, DRAFT_HEIGHT);
    draft_wall(&d, 0, -DRAFT_WALL, -h, 1.5, -h, DRAFT_WALL, DRAFT_HEIGHT);
    draft_wall(&d, 0, 2.5, -h, 4 + DRAFT_WALL, -h, DRAFT_WALL, DRAFT_HEIGHT);
    draft_room(&d, 0, 0, 0, 4, 3);
    draft_opening(&d, OPENING_DOOR, 0, 2, -h, 0, 0.98, DRAFT_WALL);
    draft_enclose(&d);
    cr_expect_eq(draft_count_kind(&d, REGION_ROOM), 1);
    cr_expect_eq(draft_count_notes(&d, NOTE_LEAK), 0);
    cr_expect_eq(draft_count_notes(&d, NOTE_CHANGED), 1, "the closing is noted");
    cr_expect(draft_joins(&d, 0, REGION_ROOM, REGION_OUTDOORS));
    draft_free(&d);
}

// Proves that a door spans two parallel walls with a void between, and that the void itself is no room.
Test(enclose, door_through_two_walls) {
    Draft d = draft_new(1);
    draft_box_walls(&d, 0, 0, 0, 7.4, 3);
    draft_wall(&d, 0, 4.05, 0, 4.05, 3, 0.1, DRAFT_HEIGHT);
    draft_wall(&d, 0, 4.25, 0, 4.25, 3, 0.1, DRAFT_HEIGHT);
    draft_room(&d, 0, 0, 0, 4, 3);
    draft_room(&d, 0, 4.3, 0, 7.4, 3);
    draft_opening(&d, OPENING_DOOR, 0, 4.15, 1.5, M_PI / 2, 0.9, 0.25);
    draft_enclose(&d);
    cr_expect_eq(draft_count_kind(&d, REGION_ROOM), 2);
    cr_expect(draft_joins(&d, 0, REGION_ROOM, REGION_ROOM));
    cr_expect_float_eq(draft_area_of(&d, REGION_OPENING), 0.3 * 0.9, 1e-9);
    cr_expect_eq(draft_kind_at(&d, 4.15, 0.5, 1), -1, "the void is part of the walls");
    draft_free(&d);
}

// Proves that rooms and doors without any walls get walls, and that the doors join.
Test(enclose, no_walls_at_all) {
    Draft d = draft_new(1);
    draft_room(&d, 0, 0, 0, 4, 3);
    draft_room(&d, 0, 4.15, 0, 7, 3);
    draft_opening(&d, OPENING_DOOR, 0, 4.07, 1.5, M_PI / 2, 0.9, 0.1);
    draft_opening(&d, OPENING_DOOR, 0, 2, -0.05, 0, 0.9, 0.1);
    draft_enclose(&d);
    cr_expect_eq(draft_count_kind(&d, REGION_ROOM), 2);
    cr_expect(draft_joins(&d, 0, REGION_ROOM, REGION_ROOM));
    cr_expect(draft_joins(&d, 1, REGION_ROOM, REGION_OUTDOORS));
    cr_expect_eq(draft_count_notes(&d, NOTE_CHANGED), 1);
    cr_expect_eq(draft_kind_at(&d, 4.07, 0.5, 1), -1, "between the rooms is wall");
    draft_free(&d);
}

// Proves that rooms with walls of their own (plans without walls) are closed by them, that doors take their
// depth from the gap, and that rooms sharing an edge are open to each other.
Test(enclose, implicit_walls) {
    Draft d = draft_new(1);
    draft_room(&d, 0, 0, 0, 4, 3);
    draft_room(&d, 0, 4.2, 0, 7, 3);
    draft_room(&d, 0, 4.2, 3, 7, 5);
    for (int i = 0; i < 3; i++) d.s.rooms[i].wall = 0.3;
    draft_opening(&d, OPENING_DOOR, 0, 4.1, 1.5, M_PI / 2, 0.9, 0);
    draft_opening(&d, OPENING_WINDOW, 0, 2, -0.15, 0, 1, 0);
    draft_enclose(&d);
    cr_expect_eq(draft_count_kind(&d, REGION_ROOM), 3);
    cr_expect_eq(d.b.note_count, 0);
    cr_expect(draft_joins(&d, 0, REGION_ROOM, REGION_ROOM));
    cr_expect(draft_joins(&d, 1, REGION_ROOM, REGION_OUTDOORS));
    cr_expect_float_eq(draft_area_of(&d, REGION_OPENING), 0.2 * 0.9 + 0.3 * 1, 1e-9);
    cr_expect_eq(draft_kind_at(&d, -0.2, 1, 1), -1);
    cr_expect_eq(draft_kind_at(&d, -0.35, 1, 1), REGION_OUTDOORS);
    draft_free(&d);
}

// Proves that walls without rooms still enclose a region.
Test(enclose, walls_but_no_rooms) {
    Draft d = draft_new(1);
    draft_box_walls(&d, 0, 0, 0, 7.2, 3);
    draft_wall(&d, 0, 4.1, 0, 4.1, 3, DRAFT_WALL, DRAFT_HEIGHT);
    draft_opening(&d, OPENING_PASSAGE, 0, 4.1, 1.5, M_PI / 2, 0.9, 0.2);
    draft_enclose(&d);
    cr_expect_eq(draft_count_kind(&d, REGION_ROOM), 2);
    cr_expect_eq(draft_count_kind(&d, REGION_OPENING), 1);
    cr_expect(draft_joins(&d, 0, REGION_ROOM, REGION_ROOM));
    cr_expect_float_eq(draft_area_of(&d, REGION_ROOM), 21, 1e-9);
    draft_free(&d);
}
