// test_enclose_low.c - walls lower than their storey that bound rooms, and those that do not; slits beside doors.
#include <criterion/criterion.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "tests/support/draft_fixture.h"

static const double TALL = 3.66,
                    INNER = 2.44;  // metres: a storey as the program had it, walls as people know them

// A house of one storey, 8 m by 4 m inside, whose outer walls reach its ceiling.
static Draft tall_house(void) {
    Draft d = draft_new(1);
    d.b.storeys[0].height = TALL;
    draft_box_walls(&d, 0, 0, 0, 8, 4);
    for (int i = 0; i < d.s.wall_count; i++) d.s.walls[i].z1 = TALL;
    return d;
}

static int low_walls(const Draft *d) {
    int count = 0;
    for (int i = 0; i < d->b.object_count; i++) count += d->b.objects[i].kind == OBJECT_LOW_WALL;
    return count;
}

static int find_note(const Draft *d, const char *words) {
    for (int i = 0; i < d->b.note_count; i++)
        if (strstr(d->b.notes[i].text, words)) return i;
    return -1;
}

// Proves that a wall of 2.44 m in a storey of 3.66 m, with a door in it, parts two rooms up to the ceiling, drawn or not; and that one
// of 1.8 m, which one sees over, stays an object in one space.
Test(enclose, low_walls_that_close_bound) {
    for (int drawn = 0; drawn < 2; drawn++) {
        for (int high = 0; high < 2; high++) {
            Draft d = tall_house();
            draft_wall(&d, 0, 4, 0, 4, 4, DRAFT_WALL, high ? INNER : 1.8);
            if (drawn) {
                draft_room(&d, 0, 0, 0, 4, 4);
                draft_room(&d, 0, 4, 0, 8, 4);
            }
            draft_opening(&d, OPENING_DOOR, 0, 4, 2, M_PI / 2, 0.9, DRAFT_WALL);
            draft_enclose(&d);
            cr_expect_eq(draft_count_kind(&d, REGION_ROOM), high || drawn ? 2 : 1);
            cr_expect_eq(low_walls(&d), !high);
            cr_expect_eq(draft_kind_at(&d, 4, 0.5, 1), high ? -1 : REGION_ROOM);
            cr_expect_eq(draft_kind_at(&d, 4, 0.5, 3), high ? -1 : REGION_ROOM, "above the wall");
            if (high) cr_expect(draft_joins(&d, 0, REGION_ROOM, REGION_ROOM));
            draft_free(&d);
        }
    }
}

// Proves that a high wall that closes nothing stays an object as high as drawn: a screen that stands free, and one with an end in a wall.
Test(enclose, low_walls_that_close_nothing_are_objects) {
    for (int end = 0; end < 2; end++) {
        Draft d = tall_house();
        draft_wall(&d, 0, 4, end ? -0.1 : 1, 4, 3, DRAFT_WALL, INNER);
        draft_room(&d, 0, 0, 0, 4, 4);
        draft_room(&d, 0, 4, 0, 8, 4);
        draft_enclose(&d);
        cr_assert_eq(low_walls(&d), 1);
        cr_expect_float_eq(d.b.objects[0].proxy->z1, INNER, 1e-12);
        cr_expect_eq(draft_kind_at(&d, 4.05, 2, 3), REGION_ROOM, "one sees over it");
        draft_free(&d);
    }
}

// Proves that walls are judged together: two screens in a line, with a gap between that another wall closes, bound; a wall whose only
// partner was taken away goes too.
Test(enclose, low_walls_bound_together) {
    for (int closed = 0; closed < 2; closed++) {
        Draft d = tall_house();
        draft_wall(&d, 0, 4, 0, 4, 1.5, DRAFT_WALL, INNER);
        draft_wall(&d, 0, 4, 2.5, 4, 4, DRAFT_WALL, INNER);
        if (closed) draft_wall(&d, 0, 4, 1.5, 4, 2.5, DRAFT_WALL, INNER);
        draft_enclose(&d);
        cr_expect_eq(draft_count_kind(&d, REGION_ROOM), closed ? 2 : 1);
        cr_expect_eq(low_walls(&d), closed ? 0 : 2);
        draft_free(&d);
    }
}

// Proves that outer walls lower than the storey close a garage, which is drawn with a ceiling, but that no fence around a garden closes
// it, with a fence through its middle or without, whether it is drawn or not; and that both are equally high there.
Test(enclose, fences_close_no_gardens) {
    for (int drawn = 0; drawn < 3; drawn++) {
        Draft d = tall_house();
        draft_wall(&d, 0, 8.1, 0.1, 12, 0.1, DRAFT_WALL, INNER);
        draft_wall(&d, 0, 8.1, 3.9, 12, 3.9, DRAFT_WALL, INNER);
        draft_wall(&d, 0, 12, 0, 12, 4, DRAFT_WALL, INNER);
        if (drawn != 1) draft_wall(&d, 0, 10, 0, 10, 4, DRAFT_WALL, INNER);
        draft_room(&d, 0, 0, 0, 8, 4);
        if (drawn > 0) draft_room(&d, 0, 8.3, 0.2, 11.9, 3.8);
        d.s.rooms[d.s.room_count - 1].open_above = drawn == 2;
        draft_opening(&d, OPENING_WINDOW, 0, 2, -0.1, 0, 0.9,
                      DRAFT_WALL);  // without it nobody sees the outdoors
        draft_enclose(&d);
        cr_expect_eq(draft_kind_at(&d, 9, 2, 1), drawn == 1 ? REGION_ROOM : REGION_OUTDOORS, "%d", drawn);
        cr_expect_eq(draft_kind_at(&d, 9, 2, 3), drawn == 1 ? REGION_ROOM : REGION_OUTDOORS);
        cr_expect_eq(low_walls(&d), drawn == 1 ? 0 : 4);
        draft_free(&d);
    }
}

// Proves that a wall which reaches the own ceilings of the rooms beside it bounds them though it leaves a gap to pass, that the rooms are
// as high as their ceilings and all above is solid or roof; and that with one of them up to the storey it is an object.
Test(enclose, low_walls_reach_ceilings_of_rooms) {
    for (int one = 0; one < 2; one++) {
        Draft d = tall_house();
        draft_wall(&d, 0, 4, 1.5, 4, 4, DRAFT_WALL, INNER);
        draft_room(&d, 0, 0, 0, 4, 4);
        draft_room(&d, 0, 4, 0, 8, 4);
        for (int i = one; i < 2; i++) {
            d.s.rooms[i].z0 = 0;
            d.s.rooms[i].z1 = INNER;
        }
        draft_enclose(&d);
        cr_expect_eq(draft_kind_at(&d, 4, 3, 1), one ? REGION_ROOM : -1);
        cr_expect_eq(low_walls(&d), one);
        cr_expect_neq(draft_kind_at(&d, 6, 2, 3), REGION_ROOM, "above a ceiling");
        cr_expect_eq(draft_kind_at(&d, 6, 2, 2.4), REGION_ROOM);
        draft_free(&d);
    }
}

// ---- slits

// A doorway of 1 m between two rooms, and a door of the given width with one jamb or none at the wall's end.
static Draft slit_house(bool drawn, double width, double centre) {
    Draft d = draft_new(1);
    draft_box_walls(&d, 0, 0, 0, 7.2, 3);
    draft_wall(&d, 0, 4.1, 0, 4.1, 1, DRAFT_WALL, DRAFT_HEIGHT);
    draft_wall(&d, 0, 4.1, 2, 4.1, 3, DRAFT_WALL, DRAFT_HEIGHT);
    if (drawn) {
        draft_room(&d, 0, 0, 0, 4, 3);
        draft_room(&d, 0, 4.2, 0, 7.2, 3);
    }
    draft_opening(&d, OPENING_DOOR, 0, 4.1, centre, M_PI / 2, width, 0.07);
    return d;
}

// Proves that a door up to 10 cm from the end of a wall closes the wall: two rooms, the door joins them, and one note counts the slits;
// that a door drawn less deep than its wall fills it all the same; and that a gap of 11 cm stays open, with one space on both sides.
Test(enclose, slits_up_to_ten_centimetres) {
    static const struct {
        double width, centre;
        int slits;
    } CASES[] = {{1.0, 1.5, 0},  {0.9, 1.5, 2},     {0.9, 1.45, 1},
                 {0.82, 1.5, 2}, {0.89, 1.445, -1}, {0.77, 1.5, -1}};
    for (int i = 0; i < 6; i++) {
        for (int drawn = 0; drawn < 2; drawn++) {
            Draft d = slit_house(drawn, CASES[i].width, CASES[i].centre);
            int slits = CASES[i].slits;
            draft_enclose(&d);
            cr_expect_eq(draft_count_kind(&d, REGION_ROOM), slits >= 0 || drawn ? 2 : 1, "case %d", i);
            int note = find_note(&d, "slits between doors");
            cr_expect_eq(note >= 0, slits > 0, "case %d", i);
            if (slits > 0) cr_expect_eq(d.b.notes[note].text[0], '0' + slits, "%s", d.b.notes[note].text);
            const Opening *o = &d.b.openings[0];
            if (slits >= 0) {
                cr_expect_eq(draft_kind_at(&d, 4.02, 1.97, 1), slits ? -1 : REGION_OPENING, "case %d", i);
                cr_expect_neq(o->region[0], o->region[1], "case %d", i);
                cr_expect_float_eq(draft_area_of(&d, REGION_OPENING), CASES[i].width * DRAFT_WALL, 1e-9,
                                   "case %d: %g", i, draft_area_of(&d, REGION_OPENING));
            } else if (!drawn) {
                cr_expect_eq(o->region[0], o->region[1], "case %d", i);
            }
            draft_free(&d);
        }
    }
}

// Proves that a door drawn before its wall, in a corner, gets no wall beside it: nobody looks through there.
Test(enclose, no_slits_before_walls) {
    Draft d = draft_new(1);
    draft_box_walls(&d, 0, 0, 0, 4, 3);
    draft_opening(&d, OPENING_DOOR, 0, 0.55, 0.055, 0, 0.98, 0.1);
    draft_enclose(&d);
    cr_expect_eq(find_note(&d, "slits between doors"), -1);
    draft_free(&d);
}

// Proves that sentences call a region by its name, as outdoors, or by a place that lies in it, even in a region around a hole.
Test(enclose, titles_of_regions) {
    Draft d = draft_new(1);
    draft_box_walls(&d, 0, 0, 0, 9, 9);
    draft_box_walls(&d, 0, 3, 3, 6, 6);
    draft_room(&d, 0, 3, 3, 6, 6);
    draft_opening(&d, OPENING_DOOR, 0, 4, -0.1, 0, 0.9, DRAFT_WALL);
    draft_enclose(&d);
    for (int i = 0; i < d.b.region_count; i++) {
        const Region *r = &d.b.regions[i];
        const char *title = region_title(&d.b, r, &d.arena);
        double x, y;
        int which = -1;
        if (r->kind == REGION_OUTDOORS) {
            cr_expect_str_eq(title, "outdoors");
        } else if (*r->name) {
            cr_expect_str_eq(title, "Room 0");
        } else if (r->kind == REGION_ROOM) {
            cr_assert_eq(sscanf(title, "a room at (%lf, %lf)", &x, &y), 2, "%s", title);
            draft_regions_at(&d, x, y, 1, &which);
            cr_expect_eq(which, i, "%s", title);
        }
    }
    draft_free(&d);
}
