// test_building_details.c - the check names faults of details, and takes what is sound.
#include <criterion/criterion.h>
#include <math.h>

#include "engine/core/polygon.h"
#include "engine/core/random.h"
#include "maps/building/building.h"
#include "tests/maps/building_fixture.h"

// The same with one of everything else: an inlay, a leaf, a tour, a note, and a ball, a patch and metaballs.
static Building detailed_building(Arena *arena) {
    static const double inlay[] = {1, 1, 2, 1, 2, 2};
    Building b = building_sound_building(arena);
    *ARENA_PUSH(arena, b.inlays, b.inlay_count, b.inlay_capacity) = (Inlay){b.point_count, 3, 0, 0};
    building_add_ring(arena, &b, inlay, 3);
    b.ring_count--;
    *ARENA_PUSH(arena, b.leaves, b.leaf_count, b.leaf_capacity) =
        (Leaf){.axis = {{4, 0}, {4, 3}}, .thickness = 0.05, .z1 = 2};
    *ARENA_PUSH(arena, b.tour_points, b.tour_point_count, b.tour_point_capacity) =
        (Viewpoint){"stop", {1, 1, 1.6}, 0, 0, 1};
    *ARENA_PUSH(arena, b.tours, b.tour_count, b.tour_capacity) = (Tour){"round", 0, 1};
    *ARENA_PUSH(arena, b.notes, b.note_count, b.note_capacity) = (Note){.text = "none"};
    for (int i = 0; i < 16; i++)
        *ARENA_PUSH(arena, b.controls, b.control_count, b.control_capacity) =
            (CurvedControl){vec3(i % 4, i / 4, 0), 1};
    *ARENA_PUSH(arena, b.trims, b.trim_count, b.trim_capacity) = (CurvedTrim){.weight = {1, 1, 1, 1}};
    *ARENA_PUSH(arena, b.balls, b.ball_count, b.ball_capacity) = (CurvedBall){{0, 0, 0}, 1, 1};
    static const CurvedKind KINDS[] = {CURVED_SPHERE, CURVED_PATCH, CURVED_METABALLS};
    for (int i = 0; i < 3; i++) {
        *ARENA_PUSH(arena, b.shapes, b.shape_count, b.shape_capacity) =
            (CurvedShape){.kind = KINDS[i],
                          .frame = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                          .trim_count = 1,
                          .ball_count = 1,
                          .threshold = 0.5,
                          .tolerance = 0.01,
                          .polygon_count = 1};
    }
    return b;
}

static const ObjectProxy UPSIDE_DOWN = {.z0 = 3, .z1 = 2};

static void spoil_details(Building *b, int way) {
    switch (way) {
    case 0:
        b->materials[0].alpha = 2;
        break;
    case 1:
        b->materials[0].mirror = 0.7f;
        break;
    case 2:
        b->materials[0].index = 9;
        break;
    case 3:
        for (int i = 0; i < 4; i++) b->vertices[i].y = 0;
        break;
    case 4:
        b->objects[0].leaf = 7;
        break;
    case 5:
        b->objects[0].proxy = &UPSIDE_DOWN;
        break;
    case 6:
        b->inlays[0].point_count = 2;
        break;
    case 7:
        b->inlays[0].z = NAN;
        break;
    case 8:
        b->points[b->inlays[0].first_point + 1] = vec2(1, 4);
        break;
    case 9:
        b->tours[0].viewpoint_count = 5;
        break;
    case 10:
        b->notes[0].text = NULL;
        break;
    case 11:
        b->openings[0].kind = OPENING_KINDS;
        break;
    case 12:
        b->openings[0].storey = 3;
        break;
    case 13:
        b->openings[0].line[0].x = NAN;
        break;
    case 14:
        b->openings[0].open = 1.5;
        break;
    case 15:
        b->openings[0].leaf_count = 4;
        break;
    case 16:
        b->openings[0].material = 8;
        break;
    case 17:
        b->leaves[0].thickness = 0;
        break;
    case 18:
        b->leaves[0].corner_count = 2;
        break;
    case 19:
        b->leaves[0].opening = 5;
        break;
    case 20:
        b->world.max.z = 1;
        break;
    case 21:
        b->shapes[0].kind = CURVED_KINDS;
        break;
    case 22:
        b->shapes[0].polygon_count = 6;
        break;
    case 23:
        b->shapes[0].tolerance = 0;
        break;
    case 24:
        b->shapes[0].frame.axis[1] = vec3(1, 1, 0);
        break;
    case 25:
        b->shapes[1].first_control = 1;
        break;
    case 26:
        b->controls[3].weight = 0;
        break;
    case 27:
        b->trims[0].point[2].x = 1.5;
        break;
    case 28:
        b->shapes[2].ball_count = 0;
        break;
    case 29:
        b->balls[0].radius = -1;
        break;
    default:
        break;
    }
}

// Proves the same of these.
Test(building, check_names_faults_of_details) {
    static const char *const expected[] = {
        "material 0 (m): alpha 2 (allowed 0 to 1)",
        "material 0 (m): mirror 0.7 beside a reflectance of 0.5 (together 0 to 1)",
        "material 0 (m): index of refraction 9 (0, or 1 to 4)",
        "polygon 0 at (0.000, 0.000, 1.000): no area",
        "object 0 (thing): leaf 7 (allowed 0 to 0)",
        "object 0 (thing): its proxy is not finite or reaches from 3 up to 2",
        "inlay 0: points 12 to 13 of 15 (at least 3, all there)",
        "inlay 0: material 0 of 1, height nan m",
        "inlay 0 at (1.000, 4.000): not convex or not counter-clockwise",
        "tour 0 (round): viewpoints 0 to 4 of 1",
        "note 0: no text, or its path lies outside the points",
        "opening 0 (gap): kind 3",
        "opening 0 (gap): storey 3 of 1",
        "opening 0 (gap): its line is not finite",
        "opening 0 (gap): open by 1.5 (allowed 0 to 1)",
        "opening 0 (gap): leaves 0 to 3 of 1",
        "opening 0 (gap): material 8 of 1",
        "leaf 0 at (0.000, 0.000): it is not finite or has no size",
        "leaf 0: corners 0 to 1 of 15 points (none, or 3 to 32)",
        "leaf 0: opening 5 of 1",
        "region 0 (unnamed): heights 0 to 2.5 m leave the world (0 to 1 m)",
        "curved shape 0: kind 5 (allowed 0 to 4)",
        "curved shape 0: polygons 0 to 5, not all of object 0; material 0 of 1",
        "curved shape 0: tolerance 0 m (above 0), top 0 (0 to 1)",
        "curved shape 0: its axes are not perpendicular, or one has no length",
        "curved shape 1: controls from 1 of 16, trims from 0 of 1",
        "curved shape 1: control 3 at (3, 0, 0), weight 0 (finite, above 0)",
        "curved shape 1: point 2 of trim 0 is (1.5, 0), weight 1 (0 to 1, above 0)",
        "curved shape 2: balls 0 to -1 of 1 (at least 1), threshold 0.5 (above 0)",
        "curved shape 2: ball 0 has radius -1, weight 1 (finite, a radius above 0)"};
    int ways = (int)(sizeof expected / sizeof *expected);
    for (int way = -1; way < ways; way++) {
        Arena arena = {0};
        Building b = detailed_building(&arena);
        spoil_details(&b, way);
        const char *faults[8] = {""};
        int count = building_check(&b, &arena, faults, 8);
        bool found = false;
        for (int i = 0; i < count && i < 8; i++)
            found = found || (way >= 0 && strstr(faults[i], expected[way]));
        cr_expect(way < 0 ? count == 0 : found, "case %d: %d faults, first: %s", way, count, faults[0]);
        arena_free(&arena);
    }
}

// Proves that a region which is convex as it is may have vertices off the grid, and that a dent of a tenth of a
// millimetre is none too small to be seen.
Test(building, convex_regions_may_leave_the_grid) {
    Arena arena = {0};
    Building b = building_sound_building(&arena);
    static const double bay[] = {-1, 0, 0, 0, 0, 1.00051, 0, 3, -1, 3.00007};
    building_add_region(&arena, &b, 0, 2.5, bay, 5);
    cr_expect(region_is_convex(&b, &b.regions[2]));
    b.points[b.point_count - 3].x = -0.0001;
    cr_expect_not(region_is_convex(&b, &b.regions[2]), "the wall bends inwards");
    arena_free(&arena);
}

// Proves that regions one above the other, side by side, and around one another are not taken for
// overlapping, and that small overlaps in space are.
Test(building, overlaps_in_space) {
    static const double room[] = {0, 0, 4, 0, 4, 3, 0, 3}, inner[] = {5, 1, 6, 1, 6, 2, 5, 2},
                        cross[] = {3.999, 1, 5, 1, 5, 2, 3.999, 2};
    Arena arena = {0};
    Building b = building_sound_building(&arena);
    b.world.max.z = 9;
    building_add_region(&arena, &b, 2.5, 5, room, 4);
    building_add_region(&arena, &b, 0, 2.5, inner, 4);
    building_faults_of(&b, &arena, NULL);
    building_add_region(&arena, &b, 4.999, 6, room, 4);
    building_faults_of(&b, &arena, "overlap");
    arena_free(&arena);
    b = building_sound_building(&arena);
    building_add_region(&arena, &b, 1, 2, cross, 4);
    building_faults_of(&b, &arena, "overlap");
    arena_free(&arena);
}

// Proves that a clipped polygon has one corner more at most, also where rounding has corners of the edge along the plane on either
// side of it, and that no corner of the rest is lost. Tolerance: the noise, along four metres.
Test(building, clipped_polygons_have_room) {
    enum { COUNT = 11 };
    const double noise = 1e-15;
    for (int turn = 0; turn < COUNT; turn++) {
        Vec3 v[COUNT], out[COUNT + 2];
        for (int i = 0; i < COUNT - 2; i++)
            v[(i + turn) % COUNT] = vec3(i * 0.5, i % 2 ? -noise * (i + 1) : noise, 0);
        v[(COUNT - 2 + turn) % COUNT] = vec3(4, 3, 0);
        v[(COUNT - 1 + turn) % COUNT] = vec3(0, 3, 0);
        out[COUNT + 1] = vec3(NAN, 0, 0);
        int kept = polygon_clip(v, COUNT, (Plane){{0, 1, 0}, 0}, 0, out);
        cr_assert(kept <= COUNT + 1 && isnan(out[COUNT + 1].x), "turn %d: %d corners", turn, kept);
        cr_assert_float_eq(polygon_area(out, kept), 12, 1e-13, "turn %d: %g m2", turn,
                           polygon_area(out, kept));
    }
}

// Proves that every kind has a name.
Test(building, names) {
    for (int i = 0; i < OPENING_KINDS; i++) cr_expect_gt(strlen(opening_kind_name((OpeningKind)i)), 0);
}

// Proves that a portal between given cells may bend by 4 mm, and not by 5 (building_check.c): a corner is moved out of the
// plane of a rectangle, of which the plane between then lies off by a quarter.
Test(building, check_knows_bent_portals) {
    static const struct {
        double moved;
        bool sound;
    } CASES[] = {{0, true}, {0.015, true}, {-0.015, true}, {0.02, false}, {-0.02, false}, {1, false}};
    for (int i = 0; i < (int)(sizeof CASES / sizeof *CASES); i++) {
        Arena arena = {0};
        Vec3 v[4] = {{0, 0, 0}, {0, 0, 1}, {CASES[i].moved, 2, 1}, {0, 2, 0}};
        GivenPortal portal = {{0, 1}, 0, 4};
        Building b = {.form = FORM_CELLS,
                      .source = "bent",
                      .given_cell_count = 2,
                      .given_portals = &portal,
                      .given_portal_count = 1,
                      .vertices = v,
                      .vertex_count = 4,
                      .world = {{-1, 0, 0}, {1, 2, 1}}};
        const char *fault = "";
        int count = building_check(&b, &arena, &fault, 1);
        cr_expect_eq(count, !CASES[i].sound, "moved by %g: %d faults, first: %s", CASES[i].moved, count,
                     fault);
        cr_expect(CASES[i].sound || strstr(fault, "bends by"), "%s", fault);
        arena_free(&arena);
    }
}
