// test_enclose_shapes.c - open plans, terraces, leaks, low walls, arcs and storeys.
#include <criterion/criterion.h>
#include <math.h>

#include "tests/support/draft_fixture.h"

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
    cr_expect_float_eq(d.b.objects[0].proxy->z1, 1.0, 1e-12);
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
