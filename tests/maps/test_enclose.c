// test_enclose.c - free space from drawn plans: the cases that break a naive reader, one by one.
#include <criterion/criterion.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

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

// Proves that open-plan space is split by room edges alone, that a strip left undrawn along a wall goes to
// its room, and that rooms drawn into their walls lose nothing.
Test(enclose, open_plan) {
    Draft d = draft_new(1);
    draft_box_walls(&d, 0, 0, 0, 8, 4);
    draft_room(&d, 0, -0.1, -0.1, 3, 4.1);
    draft_room(&d, 0, 3, 0.08, 7.95, 3.95);
    draft_enclose(&d);
    cr_expect_eq(draft_count_kind(&d, REGION_ROOM), 2);
    cr_expect_float_eq(draft_area_of(&d, REGION_ROOM), 32, 1e-9);
    cr_expect_eq(d.b.note_count, 0);
    draft_free(&d);
}

// Proves that a terrace drawn as a room is outdoors, has its own floor, and is noted; it is not lost.
Test(enclose, terrace) {
    Draft d = draft_new(1);
    draft_box_walls(&d, 0, 0, 0, 4, 3);
    draft_room(&d, 0, 0, 0, 4, 3);
    draft_room(&d, 0, 0, -3.2, 4, -0.2);
    draft_enclose(&d);
    cr_expect_eq(draft_count_kind(&d, REGION_ROOM), 1);
    cr_expect_eq(draft_kind_at(&d, 2, -1.5, 1), REGION_OUTDOORS);
    int which = -1;
    draft_regions_at(&d, 2, -1.5, 1, &which);
    cr_expect_eq(d.b.regions[which].floor_material, 1, "the drawn floor");
    cr_expect_str_eq(d.b.regions[which].name, "Room 1");
    cr_expect_eq(draft_count_notes(&d, NOTE_CHANGED), 1);
    cr_expect_float_eq(d.b.lost_area, 0, 1e-9);
    draft_free(&d);
}

// Proves that a room with a hole in its wall stays a room, and that the path noted leads from inside it
// through the hole to the open air.
Test(enclose, leak) {
    Draft d = draft_new(1);
    double h = DRAFT_WALL / 2;
    draft_box_walls(&d, 0, 0, 0, 4, 3);
    d.s.walls[1] = d.s.walls[3];  // the northern wall goes
    d.s.wall_count = 3;
    draft_wall(&d, 0, -DRAFT_WALL, 3 + h, 2, 3 + h, DRAFT_WALL, DRAFT_HEIGHT);
    draft_wall(&d, 0, 3, 3 + h, 4 + DRAFT_WALL, 3 + h, DRAFT_WALL, DRAFT_HEIGHT);
    draft_room(&d, 0, 0, 0, 4, 3);
    draft_enclose(&d);
    cr_expect_eq(draft_count_kind(&d, REGION_ROOM), 1);
    cr_assert_eq(draft_count_notes(&d, NOTE_LEAK), 1);
    const Note *note = &d.b.notes[0];
    while (note->kind != NOTE_LEAK) note++;
    cr_expect_float_eq(note->place.x, 2.5, 1e-9, "%s", note->text);
    cr_expect_float_eq(note->place.y, 3, 1e-9);
    cr_assert_geq(note->point_count, 3);
    const Vec2 *path = &d.b.points[note->first_point];
    cr_expect_eq(draft_kind_at(&d, path[0].x, path[0].y, 1), REGION_ROOM);
    bool hole = false;
    for (int i = 0; i < note->point_count; i++)
        hole = hole || (path[i].x == note->place.x && path[i].y == note->place.y);
    cr_expect(hole);
    Vec2 last = path[note->point_count - 1];
    cr_expect_eq(draft_kind_at(&d, last.x, last.y, 1), REGION_OUTDOORS);
    draft_free(&d);
}

// Proves that low walls become objects and do not divide; and that a sloped wall counts by its highest point.
Test(enclose, low_walls) {
    Draft d = draft_new(1);
    draft_box_walls(&d, 0, 0, 0, 7.2, 3);
    draft_wall(&d, 0, 4.1, 0, 4.1, 3, DRAFT_WALL, 1.0);
    draft_enclose(&d);
    cr_expect_eq(draft_count_kind(&d, REGION_ROOM), 1);
    cr_assert_eq(d.b.object_count, 1);
    cr_expect_eq(d.b.objects[0].kind, OBJECT_LOW_WALL);
    cr_expect_eq(d.b.objects[0].polygon_count, 5);
    cr_expect_float_eq(d.b.objects[0].proxy_z1, 1.0, 1e-12);
    draft_free(&d);
}

// Proves that a round wall of many corners encloses a round room and takes a door. Tolerance: the door's box
// cuts a little off the round outline.
Test(enclose, arcs) {
    enum { N = 48 };
    Draft d = draft_new(1);
    for (int half = 0; half < 2; half++) {
        Vec2 p[2 * (N + 1)];
        for (int i = 0; i <= N; i++) {
            double a = M_PI * half + M_PI * i / N;
            p[i] = vec2(3.2 * cos(a), 3.2 * sin(a));
            p[2 * N + 1 - i] = vec2(3 * cos(a), 3 * sin(a));
        }
        draft_wall_shape(&d, 0, p, 2 * (N + 1), 0, DRAFT_HEIGHT);
    }
    draft_opening(&d, OPENING_DOOR, 0, 0, -3.1, 0, 0.9, 0.2);
    draft_enclose(&d);
    cr_expect_eq(draft_count_kind(&d, REGION_ROOM), 1);
    cr_expect(draft_joins(&d, 0, REGION_ROOM, REGION_OUTDOORS));
    cr_expect_float_eq(draft_area_of(&d, REGION_ROOM), M_PI * 9, 0.15);
    draft_free(&d);
}

// Proves that a hole in a floor joins two storeys through a shaft, that the slab is solid elsewhere, and
// that walls close the slab.
Test(enclose, two_storeys_and_a_stairwell) {
    Draft d = draft_new(2);
    for (int k = 0; k < 2; k++) {
        draft_box_walls(&d, k, 0, 0, 4, 3);
        draft_room(&d, k, 0, 0, 4, 3);
    }
    draft_cutout(&d, 1, 1, 1, 2, 2);
    draft_enclose(&d);
    cr_expect_eq(draft_count_kind(&d, REGION_ROOM), 2);
    cr_assert_eq(draft_count_kind(&d, REGION_SHAFT), 1);
    cr_expect_eq(draft_kind_at(&d, 1.5, 1.5, 2.6), REGION_SHAFT);
    cr_expect_eq(draft_kind_at(&d, 2.5, 1.5, 2.6), -1);
    cr_expect_eq(draft_kind_at(&d, -0.1, 1.5, 2.6), -1);
    cr_expect_eq(draft_kind_at(&d, 1.5, 1.5, 3), REGION_ROOM);
    for (int i = 0; i < d.b.region_count; i++) {
        if (d.b.regions[i].kind != REGION_SHAFT) continue;
        cr_expect_float_eq(d.b.regions[i].z0, 2.5, 1e-12);
        cr_expect_float_eq(d.b.regions[i].z1, 2.7, 1e-12);
    }
    draft_free(&d);
}

// Proves that overlapping rooms are told apart (the first keeps the place) and self-crossing ones are used,
// with notes.
Test(enclose, overlapping_and_self_crossing_rooms) {
    Draft d = draft_new(1);
    draft_box_walls(&d, 0, 0, 0, 8, 4);
    draft_room(&d, 0, 0, 0, 4, 4);
    draft_room(&d, 0, 3, 0, 6, 4);
    Vec2 eight[4] = {{6, 0}, {8, 4}, {8, 0}, {6, 4}};
    draft_room_shape(&d, 0, eight, 4);
    draft_enclose(&d);
    cr_expect_float_eq(draft_area_of(&d, REGION_ROOM), 32, 1e-9);
    cr_expect_geq(draft_count_notes(&d, NOTE_CHANGED), 2);
    int which = -1;
    cr_expect_eq(draft_regions_at(&d, 3.5, 2, 1, &which), 1);
    cr_expect_str_eq(d.b.regions[which].name, "Room 0");
    cr_expect_eq(draft_regions_at(&d, 7.7, 2, 1, &which), 1);
    cr_expect_str_eq(d.b.regions[which].name, "Room 2");
    draft_free(&d);
}

// Proves that an opening much wider than its wall widens the world on all sides: it ends ten metres beyond the opening, twenty
// beyond the walls. Tolerance: the grid of a millimetre.
Test(enclose, wide_openings_widen_the_world) {
    for (int k = 0; k < 2; k++) {
        Draft d = draft_new(1);
        draft_box_walls(&d, 0, 0, 0, 4, 4);
        draft_room(&d, 0, 0, 0, 4, 4);
        draft_opening(&d, OPENING_DOOR, 0, k ? 2 : 4.1, k ? 4.1 : 2, k ? 0 : M_PI / 2, 60, 0.2);
        draft_enclose(&d);
        const Box *w = &d.b.world;
        const double along[2] = {k ? w->min.x : w->min.y, k ? w->max.x : w->max.y},
                     across[2] = {k ? w->min.y : w->min.x, k ? w->max.y : w->max.x};
        cr_expect_float_eq(along[0], 2 - 30 - 10, 2e-3, "from %g", along[0]);
        cr_expect_float_eq(along[1], 2 + 30 + 10, 2e-3, "to %g", along[1]);
        cr_expect_float_eq(across[0], -DRAFT_WALL - 20, 2e-3, "from %g", across[0]);
        cr_expect_float_eq(across[1], 4 + DRAFT_WALL + 20, 2e-3, "to %g", across[1]);
        draft_free(&d);
    }
}

// Proves that an arched opening keeps its rectangle as region, its corners filled by spandrels that face away from
// the wall on both sides, and a round one too.
Test(enclose, arched_opening) {
    for (int round = 0; round < 2; round++) {
        enum { N = 24 };
        Draft d = draft_new(1);
        draft_box_walls(&d, 0, 0, 0, 4, 3);
        SketchOpening *o = draft_opening(&d, OPENING_WINDOW, 0, 2, -0.1, 0, 1, 0.2);
        Vec2 p[N];
        for (int i = 0; i < N; i++) {
            double a = 2 * M_PI * i / N;
            p[i] = vec2(0.5 + 0.5 * cos(a), 0.5 + 0.5 * sin(a));
            if (!round && i > N / 2) p[i] = i == N - 1 ? vec2(1, 0) : vec2(0, 0);
        }
        o->first_cutout = draft_points(&d, p, N, false);
        o->cutout_count = N;
        draft_enclose(&d);
        cr_assert_eq(d.b.object_count, 1);
        cr_expect_eq(d.b.objects[0].kind, OBJECT_FRAME);
        double front = 0, back = 0;
        for (int i = 0; i < d.b.polygon_count; i++) {
            const Vec3 *v = &d.b.vertices[d.b.polygons[i].first_vertex];
            double area = polygon_area(v, d.b.polygons[i].vertex_count);
            double facing = plane_of_polygon(v, d.b.polygons[i].vertex_count).n.y;
            if (facing < -0.9 && fabs(v[0].y + 0.195) < 1e-6) front += area;
            if (facing > 0.9 && fabs(v[0].y + 0.005) < 1e-6) back += area;
        }
        double circle = 0.5 * N * 0.25 * sin(2 * M_PI / N);  // of the unit square
        double left = round ? 1 - circle : 0.5 - circle / 2;
        cr_expect_float_eq(front, left * 1.1, 0.01, "round %d: %g", round, front);
        cr_expect_float_eq(back, left * 1.1, 0.01, "round %d: %g", round, back);
        draft_free(&d);
    }
}

// Proves that stacked openings of one wall both open, and that of overlapping ones the first wins.
Test(enclose, stacked_and_overlapping_openings) {
    Draft d = draft_new(1);
    draft_box_walls(&d, 0, 0, 0, 4, 3);
    SketchOpening *low = draft_opening(&d, OPENING_WINDOW, 0, 2, -0.1, 0, 1, 0.2);
    low->sill = 0.5;
    low->head = 1.2;
    SketchOpening *high = draft_opening(&d, OPENING_WINDOW, 0, 2, -0.1, 0, 1, 0.2);
    high->sill = 1.4;
    high->head = 2.2;
    SketchOpening *third = draft_opening(&d, OPENING_WINDOW, 0, 2.2, -0.1, 0, 0.5, 0.2);
    third->sill = 1;
    third->head = 2;
    draft_enclose(&d);
    cr_expect_eq(d.b.opening_count, 2);
    cr_expect_eq(draft_kind_at(&d, 2, -0.1, 1), REGION_OPENING);
    cr_expect_eq(draft_kind_at(&d, 2, -0.1, 2), REGION_OPENING);
    cr_expect_eq(draft_kind_at(&d, 2, -0.1, 1.3), -1);
    cr_expect_eq(draft_count_notes(&d, NOTE_DROPPED), 1);
    draft_free(&d);
}

// Volume within polygons that face outwards, m^3, and their box.
static double solid_of(const Building *b, const Object *object, Box *box) {
    double volume = 0;
    *box = box_empty();
    for (int i = object->first_polygon; i < object->first_polygon + object->polygon_count; i++) {
        const Polygon *p = &b->polygons[i];
        const Vec3 *v = &b->vertices[p->first_vertex];
        for (int k = 0; k < p->vertex_count; k++) *box = box_add(*box, v[k]);
        if (b->materials[p->material].alpha < 1) continue;
        for (int k = 1; k + 1 < p->vertex_count; k++)
            volume += vec3_dot(v[0], vec3_cross(v[k], v[k + 1])) / 6;
    }
    return volume;
}

// Proves what leaves are made of: slabs of 4 cm that clear jambs, sill and head by 1 cm; in thin walls of 6 tenths of the wall; in
// two halves where they hang on both sides; glazed ones frames of 9 cm, 20 below, around a pane. None where there is no room.
Test(enclose, leaves_fill_their_doorways) {
    static const struct {
        double wall, width;
        int hinge;
        bool glazed;
        int leaves;
    } CASES[] = {{0.2, 0.9, 0, false, 1}, {0.2, 0.9, 1, false, 1}, {0.05, 0.9, 0, false, 1},
                 {0.2, 1.6, 2, false, 2}, {0.2, 0.9, 0, true, 1},  {0.2, 1.6, 2, true, 2},
                 {0.2, 0.4, 0, true, 1},  {0.2, 0.07, 0, false, 0}};
    for (int i = 0; i < 8; i++) {
        Draft d = draft_new(1);
        draft_box_walls(&d, 0, 0, 0, 4, 3);
        draft_wall(&d, 0, 2, 0, 2, 3, CASES[i].wall, DRAFT_HEIGHT);
        draft_room(&d, 0, 0, 0, 2 - CASES[i].wall / 2, 3);
        draft_room(&d, 0, 2 + CASES[i].wall / 2, 0, 4, 3);
        SketchOpening *o =
            draft_opening(&d, OPENING_DOOR, 0, 2, 1.5, M_PI / 2, CASES[i].width, CASES[i].wall);
        o->hinge = CASES[i].hinge;
        o->glazed = CASES[i].glazed;
        draft_enclose(&d);
        cr_expect_eq(d.b.leaf_count, CASES[i].leaves, "case %d: %d leaves", i, d.b.leaf_count);
        double thickness = fmin(0.04, 0.6 * CASES[i].wall);
        for (int k = 0; k < d.b.object_count; k++) {
            const Object *object = &d.b.objects[k];
            if (object->kind != OBJECT_LEAF) continue;
            const Leaf *leaf = &d.b.leaves[object->leaf];
            double half = CASES[i].width / CASES[i].leaves, width = half - 0.02, height = 2 - 0.02;
            double low = 1.5 - CASES[i].width / 2 + (object->leaf == 1 ? half : 0) + 0.01;
            bool framed = CASES[i].glazed && width >= 0.4;
            double pane = framed ? (width - 0.18) * (height - 0.29) : 0;
            Box box;
            double volume = solid_of(&d.b, object, &box);
            cr_expect_float_eq(volume, (width * height - pane) * thickness, 1e-9, "case %d: %g m^3", i,
                               volume);
            Box want = {{2 - thickness / 2, low, 0.01}, {2 + thickness / 2, low + width, 1.99}};
            cr_expect_lt(vec3_length(vec3_sub(box.min, want.min)) + vec3_length(vec3_sub(box.max, want.max)),
                         1e-9, "case %d: leaf from %g to %g m", i, box.min.y, box.max.y);
            // Its pivot stands half its thickness within the hinged end, on its axis.
            bool at_end = CASES[i].hinge == 1 || object->leaf == 1;
            double pivot = at_end ? low + width - thickness / 2 : low + thickness / 2;
            cr_expect_lt(vec2_length(vec2_sub(leaf->pivot, vec2(2, pivot))), 1e-9, "case %d: pivot at %g,%g",
                         i, leaf->pivot.x, leaf->pivot.y);
            cr_expect_float_eq(fabs(leaf->turn), 1.5, 1e-12);
        }
        draft_free(&d);
    }
}

// The length of a ray from inside regions to the outline of one, metres.
static double view_in(const Building *b, const Region *r, Vec2 from, double angle) {
    double nearest = INFINITY;
    for (int k = r->first_ring; k < r->first_ring + r->ring_count; k++) {
        for (int i = 0; i < b->rings[k].point_count; i++) {
            const Vec2 *p = b->points + b->rings[k].first_point;
            Vec2 a = vec2_sub(p[i], from), edge = vec2_sub(p[(i + 1) % b->rings[k].point_count], p[i]),
                 way = vec2(cos(angle), sin(angle));
            double across = vec2_cross(way, edge), t = vec2_cross(a, edge) / across,
                   u = vec2_cross(a, way) / across;
            if (across != 0 && t > 0 && u >= 0 && u <= 1) nearest = fmin(nearest, t);
        }
    }
    return nearest;
}

// Proves where a walk begins: in the room with a door to the open, however small, as far from its walls as anyone can be, and along
// the longest of 32 views. A fortieth of the room's box is how finely places are tried.
Test(enclose, starts_in_the_middle_of_the_entrance) {
    for (int turn = 0; turn < 6; turn++) {
        Draft d = draft_new(1);
        d.turn = 0.3 * turn;
        Vec2 l[6] = {{0, 0}, {5, 0}, {5, 2}, {2.2, 2}, {2.2, 6}, {0, 6}};
        for (int i = 0; i < 6; i++) {
            Vec2 a = l[i], c = l[(i + 1) % 6],
                 along = vec2_scale(vec2_sub(c, a), 1 / vec2_length(vec2_sub(c, a)));
            // Past the corners, but not into the room where it bends inwards.
            Vec2 out = vec2(along.y * 0.1, -along.x * 0.1);
            Vec2 before = vec2_scale(along, i == 3 ? 0 : 0.2), after = vec2_scale(along, i == 2 ? 0 : 0.2);
            a = vec2_sub(vec2_add(a, out), before);
            c = vec2_add(vec2_add(c, out), after);
            draft_wall(&d, 0, a.x, a.y, c.x, c.y, 0.2, DRAFT_HEIGHT);
        }
        draft_room_shape(&d, 0, l, 6);
        draft_box_walls(&d, 0, 10, 0, 30, 20);  // larger, and closed
        draft_room(&d, 0, 10, 0, 30, 20);
        draft_opening(&d, OPENING_DOOR, 0, 4, -0.1, 0, 0.9, 0.2);
        draft_enclose(&d);
        int which = -1;
        Vec3 s = d.b.start;
        for (int i = 0; i < d.b.region_count; i++)
            if (strcmp(d.b.regions[i].name, "Room 0") == 0) which = i;
        cr_assert_geq(which, 0);
        const Region *room = &d.b.regions[which];
        Vec2 at = vec2(s.x, s.y),
             back = vec2(cos(d.turn) * s.x + sin(d.turn) * s.y, cos(d.turn) * s.y - sin(d.turn) * s.x);
        cr_expect(back.x > 0 && back.y > 0 && (back.x < 2.2 || back.y < 2) && back.x < 5 && back.y < 6,
                  "turn %d: starts at %g,%g", turn, back.x, back.y);
        double depth = INFINITY;
        for (int k = 0; k < 720; k++) depth = fmin(depth, view_in(&d.b, room, at, M_PI * k / 360));
        // The inner corner leaves a circle of 2.1 / 2 m and somewhat more in the angle of the L.
        cr_expect_gt(depth, 1.03, "turn %d: %g m to the walls", turn, depth);
        double longest = 0;
        for (int k = 0; k < 32; k++) longest = fmax(longest, view_in(&d.b, room, at, 2 * M_PI * k / 32));
        cr_expect_float_eq(view_in(&d.b, room, at, d.b.start_yaw), longest, 1e-9, "turn %d", turn);
        cr_expect_float_eq(s.z, room->z0 + 1.6, 1e-9);
        draft_free(&d);
    }
}

// Proves that a door against a wall is kept and says which side is blocked.
Test(enclose, door_that_leads_nowhere) {
    Draft d = draft_new(1);
    draft_box_walls(&d, 0, 0, 0, 4, 3);
    draft_room(&d, 0, 0, 0, 4, 3);
    Vec2 rock[4] = {{0, -2}, {4, -2}, {4, -0.19}, {0, -0.19}};
    draft_wall_shape(&d, 0, rock, 4, M_PI / 2, DRAFT_HEIGHT);
    draft_opening(&d, OPENING_DOOR, 0, 2, -0.1, 0, 0.9, 0.2);
    draft_enclose(&d);
    cr_assert_eq(d.b.opening_count, 1);
    cr_expect_neq(d.b.openings[0].reason, NULL);
    cr_expect_eq((d.b.openings[0].region[0] < 0) + (d.b.openings[0].region[1] < 0), 1);
    draft_free(&d);
}

// Proves that what has no size, lies on no storey or is far away is dropped with a note or refused with a
// sentence, and that an empty plan is refused.
Test(enclose, bad_input) {
    Draft d = draft_new(1);
    Error error = {""};
    cr_expect_not(maps_enclose(&d.s, &d.b, &d.arena, &error));
    cr_expect(strlen(error.text) > 0);
    draft_box_walls(&d, 0, 0, 0, 4, 3);
    draft_wall(&d, 0, 1, 1, 1, 1, 0.1, DRAFT_HEIGHT);
    draft_wall(&d, 0, 1, 1, 3, 1, 0, DRAFT_HEIGHT);
    draft_room(&d, 0, 1, 1, 1, 2);
    draft_room(&d, 0, 0, 0, 4, 3);
    d.s.rooms[0].storey = 0;
    draft_room(&d, 0, 1, 1, 2, 2);
    d.s.rooms[2].storey = 7;
    draft_opening(&d, OPENING_DOOR, 0, 2, -0.1, 0, 0, 0.2);
    draft_opening(&d, OPENING_DOOR, 0, 2, -0.1, 0, 1, 0.2)->storey = -3;
    draft_enclose(&d);
    cr_expect_eq(draft_count_kind(&d, REGION_ROOM), 1);
    cr_expect_eq(draft_count_notes(&d, NOTE_DROPPED), 6);
    draft_free(&d);
    static const double bad[4] = {NAN, INFINITY, 2e8, -1e300};
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 3; k++) {
            Draft e = draft_new(1);
            draft_box_walls(&e, 0, 0, 0, 4, 3);
            draft_opening(&e, OPENING_DOOR, 0, 2, -0.1, 0, 0.9, 0.2);
            if (k == 0) e.s.points[5].x = bad[i];
            if (k == 1) e.s.openings[0].centre.y = bad[i];
            if (k == 2) e.s.walls[1].z1 = bad[i];
            error.text[0] = 0;
            cr_expect_not(maps_enclose(&e.s, &e.b, &e.arena, &error), "case %d %d", i, k);
            cr_expect(strlen(error.text) > 0);
            draft_free(&e);
        }
    }
}

// Proves that each number of a sketch, and each run of points, is looked at before anything is computed with it, and that the
// sentence says which one is wrong.
Test(enclose, each_number_is_checked) {
    enum { NUMBERS = 19, RUNS = 8 };
    for (int i = 0; i < NUMBERS + RUNS; i++) {
        Draft d = draft_new(2);
        Error error = {""};
        draft_box_walls(&d, 0, 0, 0, 4, 3);
        draft_room(&d, 0, 0, 0, 4, 3);
        SketchOpening *o = draft_opening(&d, OPENING_DOOR, 0, 2, -0.1, 0, 0.9, 0.2);
        draft_cutout(&d, 1, 1, 1, 2, 2);
        SketchWall *w = &d.s.walls[1];
        SketchRoom *r = &d.s.rooms[0];
        Storey *s = &d.b.storeys[1];
        const struct {
            double *number;
            const char *said;
        } NUMBER[NUMBERS] = {
            {&w->z0, "wall-2: its foot is "},         {&w->z1, "wall-2: its top is "},
            {&w->angle, "wall-2: its angle is "},     {&r->z0, "room-0: its floor is "},
            {&r->z1, "room-0: its ceiling is "},      {&r->wall, "room-0: its wall thickness is "},
            {&o->centre.x, "opening-0: its x is "},   {&o->centre.y, "opening-0: its y is "},
            {&o->angle, "opening-0: its angle is "},  {&o->width, "opening-0: its width is "},
            {&o->depth, "opening-0: its depth is "},  {&o->sill, "opening-0: its sill is "},
            {&o->head, "opening-0: its head is "},    {&o->swing, "opening-0: its swing is "},
            {&o->slide, "opening-0: its slide is "},  {&d.s.ground, "the ground: its height is "},
            {&s->floor, "storey 1 (storey): floor "}, {&s->height, "storey 1 (storey): floor "},
            {&s->slab, "storey 1 (storey): floor "}};
        const struct {
            int *number, by;
            const char *said;
        } RUN[RUNS] = {{&w->first_point, -5, "wall-2: points -1 to 2 of 24"},
                       {&w->point_count, -9, "wall-2: points 4 to -2 of 24"},
                       {&w->point_count, 17, "wall-2: points 4 to 24 of 24"},
                       {&r->first_point, 5, "room-0: points 21 to 24 of 24"},
                       {&r->point_count, 99, "room-0: points 16 to 118 of 24"},
                       {&d.s.cutouts[0].point_count, 1, "points 20 to 24 of 24"},
                       {&d.s.cutouts[0].first_point, 1, "points 21 to 24 of 24"},
                       {&o->cutout_count, 99, "opening-0: points 0 to 98 of 24"}};
        cr_assert_eq(d.s.point_count, 24);
        const char *said = i < NUMBERS ? NUMBER[i].said : RUN[i - NUMBERS].said;
        if (i < NUMBERS)
            *NUMBER[i].number = i % 2 ? INFINITY : -1e9;
        else
            *RUN[i - NUMBERS].number += RUN[i - NUMBERS].by;
        cr_expect_not(maps_enclose(&d.s, &d.b, &d.arena, &error), "%s is not refused", said);
        cr_expect(strstr(error.text, said), "%s (expected: %s)", error.text, said);
        draft_free(&d);
    }
}
