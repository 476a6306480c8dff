// test_enclose_doors.c - leaves in their doorways, the place where a walk starts, and bad input.
#include <criterion/criterion.h>
#include <math.h>

#include "tests/support/draft_fixture.h"

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
