// test_room_light.c - grids of rooms, the share of light that comes from other rooms, and the figures made of both.
#include <criterion/criterion.h>
#include <stdio.h>
#include <string.h>

#include "radiosity/planner/room_light.h"
#include "radiosity/show/gather.h"
#include "tests/radiosity/shoot/sky_fixture.h"

// ---- grids

// Proves the spacing of EN 12464-1 at sides that the formula makes round, and its upper end.
Test(room_grid, spacing) {
    cr_expect_float_eq(room_grid_spacing(1), 0.2, 1e-12);
    cr_expect_float_eq(room_grid_spacing(10), 1, 1e-12);
    cr_expect_float_eq(room_grid_spacing(100), 5, 1e-12);
    cr_expect_float_eq(room_grid_spacing(5000), 10, 1e-12);
}

static RoomGrid grid_of(Lit *lit, int room) {
    const Building *b = lit->graph.building;
    for (int r = 0; r < b->region_count; r++)
        if (b->regions[r].kind == REGION_ROOM && room-- == 0)
            return room_grid(b, &b->regions[r], &lit->arena);
    cr_assert_fail("no such room");
    return (RoomGrid){.point_count = 0};
}

static const char SURFACES[] = "floor oak ceiling white walls white wall 0.2";

static Lit *plan_of(const char *rooms, double element) {
    Arena arena = {0};
    Lit *lit = sky_read_plan_with(rooms, element, 2);
    arena_free(&arena);
    return lit;
}

// Proves counts and places of points worked out by hand: 4 x 4 m, strip 0.5 m, side 3 m, spacing 0.431 m: 7 points; 12 x 3 m, strip
// 0.45 m, the shorter side of 2.1 m tells the spacing, 0.336 m: 6 points across and 32 along.
Test(room_grid, of_rectangles) {
    Arena arena = {0};
    Lit *lit = plan_of(arena_format(&arena, "room a 0,0 4,0 4,4 0,4 %s\nroom b 10,0 22,0 22,3 10,3 %s\n",
                                    SURFACES, SURFACES),
                       1);
    RoomGrid square = grid_of(lit, 0), hall = grid_of(lit, 1);
    cr_expect_float_eq(square.border, 0.5, 1e-12);
    cr_expect(square.count[0] == 7 && square.count[1] == 7 && square.point_count == 49);
    cr_expect_float_eq(square.points[0].x, 0.5 + 1.5 / 7, 1e-9);
    cr_expect_float_eq(square.points[48].y, 3.5 - 1.5 / 7, 1e-9);
    cr_expect_float_eq(hall.border, 0.45, 1e-12);
    cr_expect(hall.count[0] == 32 && hall.count[1] == 6 && hall.point_count == 192, "%d x %d", hall.count[0],
              hall.count[1]);
    lit_free(lit);
    arena_free(&arena);
}

// Proves that points of a room that is no rectangle lie in it and not in the strip, at any angle; that turning the room moves its points
// with it; and that a room too narrow for a strip or for a cell has points all the same.
Test(room_grid, of_other_rooms) {
    Arena arena = {0};
    Lit *lit = plan_of(arena_format(&arena,
                                    "room l 0,0 6,0 6,3 3,3 3,6 0,6 %s\nroom t 10,0 14,3 11,7 7,4 %s\n"
                                    "room n 20,0 20.1,0 20.1,5 20,5 %s\n",
                                    SURFACES, SURFACES, SURFACES),
                       1);
    RoomGrid l = grid_of(lit, 0), turned = grid_of(lit, 1), narrow = grid_of(lit, 2);
    int in_notch = 0;
    for (int i = 0; i < l.point_count; i++) {
        Vec2 p = l.points[i];
        bool good = p.x > 0.49 && p.y > 0.49 && p.x < 5.51 && p.y < 5.51 && !(p.x > 2.51 && p.y > 2.51);
        in_notch += !good;
    }
    cr_expect(l.point_count > 30 && in_notch == 0, "%d of %d points are no points of the room", in_notch,
              l.point_count);
    cr_expect_lt(l.point_count, l.count[0] * l.count[1]);
    // 5 x 5 m: side 4 m, spacing 0.528 m: 8 points.
    cr_expect(turned.count[0] == 8 && turned.count[1] == 8 && turned.point_count == 64, "%d x %d, %d",
              turned.count[0], turned.count[1], turned.point_count);
    cr_expect_gt(narrow.point_count, 0);
    for (int i = 0; i < narrow.point_count; i++)
        cr_expect(narrow.points[i].x > 20 && narrow.points[i].x < 20.1);
    lit_free(lit);
    arena_free(&arena);
}

// ---- light

// Two rooms joined by a passage, whose two mouths have black sheets that a test hides or shows; lamps in both; a third room by itself.
static Lit *joined_rooms(void) {
    return plan_of("material lamp reflectance 0 emission 40\nmaterial dim reflectance 0 emission 8\nmaterial "
                   "black reflectance 0\n"
                   "room a 0,0 3,0 3,4 0,4 floor oak ceiling white walls white wall 0.2\n"
                   "room b 3.2,0 6.2,0 6.2,3 3.2,3 floor oak ceiling white walls white wall 0.2\n"
                   "room c 0,10 3,10 3,13 0,13 floor oak ceiling white walls white wall 0.2\n"
                   "passage p 3.1,1.5 angle 90 width 1 height 2.1\n"
                   "model l\n  box -0.2,-0.2,0 0.2,0.2,0.05 lamp\nend\n"
                   "model d\n  box -0.2,-0.2,0 0.2,0.2,0.05 dim\nend\n"
                   "model sheet\n  box 0,-0.5,0 0.001,0.5,2.1 black\nend\n"
                   "place l 1.2,2.6,2.3\nplace d 5,1,2.3\nplace d 1.5,11.5,2.3\n"
                   "place sheet 3.0,1.5,0\nplace sheet 3.199,1.5,0\n",
                   0.25);
}

static void show_sheets(Lit *lit, bool shown) {
    for (int f = 0; f < lit->mesh.face_count; f++) {
        const char *name = mesh_material(&lit->mesh, f)->name;
        if (name && strcmp(name, "black") == 0) lit->mesh.faces[f].hidden = !shown;
    }
}

static RoomLight light_of(Lit *lit, int threads) {
    RoomLight light = {.mesh = &lit->mesh, .forest = &lit->forest, .options = rad_default_options()};
    light.options.residual = 1e-5;
    light.options.threads = threads;
    room_lux(light.weight);
    return light;
}

static void shoot_both(RoomLight *light, Arena *arena) {
    Error error;
    cr_assert(room_light_open(light, NULL, arena, &error), "%s", error.text);
    cr_assert(room_light_close(light, NULL, arena, &error), "%s", error.text);
}

static double rms_of(const double *a, const double *b, int count) {
    double squares = 0, mean = 0;
    for (int i = 0; i < count; i++) {
        squares += (a[i] - b[i]) * (a[i] - b[i]) / count;
        mean += b[i] / count;
    }
    return sqrt(squares) / mean;
}

// Proves that light without other rooms is that of a bake of its own, with black sheets in both mouths of the passage, on the same mesh:
// room by room, and at each point. And that what comes from other rooms is the difference. Tolerance: 2e-4 of the mean, four times what is
// found: the rows of patches beside the mouths mend close pairs with the sheets anew.
Test(room_light, from_other_rooms_is_the_difference, .timeout = 200) {
    Lit *lit = joined_rooms();
    show_sheets(lit, false);
    RoomLight light = light_of(lit, 0);
    RoomPlan plan = room_plan(&lit->graph, 0.85, &lit->arena);
    shoot_both(&light, &lit->arena);
    RoomValues values = room_values(&plan, &light, 0, &lit->arena);
    show_sheets(lit, true);
    RoomLight shut = light_of(lit, 0);
    Error error;
    cr_assert(room_light_open(&shut, NULL, &lit->arena, &error), "%s", error.text);
    shut.closed = shut.open;
    shut.closed_mesh = lit->mesh;
    shut.closed_mesh.panes = (Panes){.panes = NULL};
    RoomValues black = room_values(&plan, &shut, 0, &lit->arena);
    cr_assert_eq(plan.room_count, 3);
    for (int r = 0; r < plan.room_count; r++) {
        int first = plan.rooms[r].first_point, count = plan.rooms[r].grid.point_count;
        RoomFigures found = room_figures(&plan, r, &values), without = room_figures(&plan, r, &black);
        double share = 1 - without.mean / found.mean,
               off = rms_of(values.own + first, black.all + first, count);
        printf(
            "room %d: %.2f lux, %.5f from other rooms, by a bake of its own %.5f; points differ by %.4f %%\n",
            r, found.mean, found.from_rooms, share, 100 * off);
        cr_expect_float_eq(found.from_rooms, share, 2e-4);
        cr_expect_lt(off, 2e-4);
        // A room by itself has all its light from itself, to the residuals of both.
        if (r == 2) cr_expect_lt(rms_of(values.own + first, values.all + first, count), 1e-4);
    }
    RoomFigures a = room_figures(&plan, 0, &values), b = room_figures(&plan, 1, &values);
    cr_expect(a.from_rooms > 0.001 && a.from_rooms < 0.05 && b.from_rooms > 0.2, "%g, %g", a.from_rooms,
              b.from_rooms);
    room_light_end(&light);
    room_light_end(&shut);
    lit_free(lit);
}

// Proves that no power is lost when rooms are closed, and that one thread and two find the same bytes.
Test(room_light, conserved_and_the_same_on_threads, .timeout = 200) {
    Lit *lit = joined_rooms();
    show_sheets(lit, false);
    RoomPlan plan = room_plan(&lit->graph, 0.85, &lit->arena);
    RoomValues values[2];
    for (int t = 0; t < 2; t++) {
        RoomLight light = light_of(lit, t + 1);
        shoot_both(&light, &lit->arena);
        const RadSolution *s = &light.closed;
        double unshot = 0, emitted = rgb_sum(s->emitted);
        for (int p = 0; p < s->patch_count; p++) unshot += rgb_sum(s->unshot[p]) * lit->mesh.patches[p].area;
        cr_expect_float_eq((rgb_sum(s->absorbed) + rgb_sum(s->escaped) + unshot) / emitted, 1, 1e-9);
        values[t] = room_values(&plan, &light, t + 1, &lit->arena);
        room_light_end(&light);
    }
    size_t bytes = (size_t)plan.point_count * sizeof(double);
    cr_expect_eq(memcmp(values[0].all, values[1].all, bytes), 0);
    cr_expect_eq(memcmp(values[0].own, values[1].own, bytes), 0);
    lit_free(lit);
}

// ---- figures

// Proves mean, least, uniformity, what half and 95 % of points reach, and that points inside things do not count, on numbers by hand.
Test(room_light, figures) {
    double all[21], own[21];
    for (int i = 0; i < 20; i++) all[i] = 100 + 10 * i, own[i] = 0.75 * all[i];
    all[20] = own[20] = NAN;
    PlannedRoom room = {.grid = {.point_count = 21}};
    RoomPlan plan = {.rooms = &room, .room_count = 1, .point_count = 21};
    RoomFigures f = room_figures(&plan, 0, &(RoomValues){all, own});
    cr_expect(f.points == 20 && f.inside == 1);
    cr_expect_float_eq(f.mean, 195, 1e-9);
    cr_expect_float_eq(f.uniformity, 100 / 195.0, 1e-12);
    cr_expect(f.minimum == 100 && f.maximum == 290);
    cr_expect_float_eq(f.from_rooms, 0.25, 1e-12);
    // Ten of twenty reach 200, nineteen reach 110.
    cr_expect(f.half == 200 && f.most == 110, "%g, %g", f.half, f.most);
}

// Proves the levels of EN 17037 at and just below their targets, both of which count.
Test(room_light, daylight_levels) {
    cr_expect_eq(daylight_level(300, 100), DAYLIGHT_LEVEL_MINIMUM);
    cr_expect_eq(daylight_level(299.9, 500), DAYLIGHT_LEVEL_NONE);
    cr_expect_eq(daylight_level(1000, 99.9), DAYLIGHT_LEVEL_NONE);
    cr_expect_eq(daylight_level(500, 300), DAYLIGHT_LEVEL_MEDIUM);
    cr_expect_eq(daylight_level(750, 499), DAYLIGHT_LEVEL_MEDIUM);
    cr_expect_eq(daylight_level(750, 500), DAYLIGHT_LEVEL_HIGH);
    cr_expect_eq(daylight_level(NAN, NAN), DAYLIGHT_LEVEL_NONE);
}

// Level ground under a sky of even radiance L receives pi L: a daylight factor of 1, whatever the sky's colour.
Test(room_light, level_ground_has_all_daylight) {
    static const double RADIANCE[2][3] = {{1, 1, 1}, {0.2, 3, 7}};
    for (int k = 0; k < 2; k++) {
        Daylight day = daylight_uniform(RADIANCE[k]);
        double weight[3], factor = 0;
        room_daylight_factor(&day, weight);
        for (int c = 0; c < 3; c++) factor += weight[c] * M_PI * RADIANCE[k][c];
        cr_expect_float_eq(factor, 1, 1e-12);
    }
}
