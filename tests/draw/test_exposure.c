// test_exposure.c - the eye adapts: to what is seen, in time, the same every time.
#include <criterion/criterion.h>

#include "engine/draw/view.h"
#include "engine/lit/exposure.h"
#include "engine/scene/light_level.h"
#include "tests/radiosity/shoot/sky_fixture.h"
#include "tests/support/lit_fixture.h"
#include "tests/support/support.h"

typedef struct Seen {
    Lit *lit;
    LitMesh *mesh;
    LitLight light;
    RadSolution solution;
    int *objects;
} Seen;

// A soup of two rooms side by side, 4 m wide each, without a way from one to the other.
static Seen open_rooms(double element) {
    Seen s = {.lit = lit_new()};
    lit_box(s.lit, vec3(0, 0, 0), vec3(4, 4, 3), true, LIT_WALL, 0);
    lit_box(s.lit, vec3(5, 0, 0), vec3(9, 4, 3), true, LIT_WALL, 0);
    lit_finish(s.lit, element, 2);
    Arena *arena = &s.lit->arena;
    const Mesh *mesh = &s.lit->mesh;
    s.solution = (RadSolution){.element_count = mesh->element_count, .patch_count = mesh->patch_count};
    s.solution.radiosity = arena_alloc(arena, (size_t)mesh->element_count, sizeof *s.solution.radiosity);
    s.mesh = lit_mesh_new(mesh, arena, arena);
    s.light = lit_light_new(s.mesh, arena);
    s.objects = ARENA_ARRAY(arena, int, s.lit->graph.object_count);
    for (int o = 0; o < s.lit->graph.object_count; o++) s.objects[o] = o;
    return s;
}

// Each room in its own even light.
static void light(Seen *s, double left, double right) {
    for (int e = 0; e < s->lit->mesh.element_count; e++) {
        double b = s->mesh->spot[e][0] + s->mesh->origin.x < 4.5 ? left : right;
        for (int c = 0; c < 3; c++) s->solution.radiosity[e][c] = b;
    }
    lit_light_fill(s->mesh, &s->solution, NULL, &s->light);
}

static double meter(const Seen *s, double x, double yaw) {
    Camera camera = camera_look(vec3(x, 2, 1.6), yaw, 0, 1.2, 160, 90);
    return exposure_meter(s->mesh, &s->light, &camera, s->objects, s->lit->graph.object_count);
}

// Proves that the meter reads what is in view: in even light that light from anywhere, whatever its unit; and of two rooms
// the one looked at. What lies behind the eye does not count.
Test(exposure, meters_what_is_in_view) {
    Seen s = open_rooms(0.5);
    for (int k = -3; k <= 3; k += 3) {
        double b = pow(10, k);
        light(&s, b, b);
        cr_expect_float_eq(meter(&s, 2, 0.3), b, 1e-5 * b);
        cr_expect_float_eq(s.light.level, b, 1e-5 * b);
    }
    light(&s, 1, 50);
    cr_expect_float_eq(meter(&s, 2, M_PI), 1, 1e-5, "away from the bright room");
    cr_expect_float_eq(meter(&s, 7, 0), 50, 1e-3, "away from the dim room");
    light(&s, 0, 0);
    cr_expect_eq(meter(&s, 2, 0), 0, "the dark has no level");
    lit_free(s.lit);
}

// Light of places in the left room, W/m^2.
static double by_side(Vec3 p) { return p.y < 2 ? 1 : 16; }
static double by_wall(Vec3 p) { return p.x > 3.999 ? 25 : 1; }
static double by_floor(Vec3 p) { return p.z < 0.001 ? 0.04 : 1; }
static double by_place(Vec3 p) { return exp(sin(2 * p.x) + cos(3 * p.y) + p.z); }

// Where a line from inside the left room meets its walls.
static Vec3 end_in_room(Vec3 eye, Vec3 way) {
    double x = (way.x > 0 ? 4 - eye.x : -eye.x) / way.x, y = (way.y > 0 ? 4 - eye.y : -eye.y) / way.y;
    double z = (way.z > 0 ? 3 - eye.z : -eye.z) / way.z;
    return vec3_add(eye, vec3_scale(way, fmin(x, fmin(y, z))));
}

// The mean of logarithms over all directions in view, weighted by the root of their light: pixel by pixel.
static double oracle(const Camera *camera, double (*light_at)(Vec3 p)) {
    enum { ACROSS = 320, DOWN = 180 };
    double weight = 0, logs = 0;
    for (int i = 0; i < ACROSS * DOWN; i++) {
        double u = camera->tan_x * ((i % ACROSS + 0.5) * 2 / ACROSS - 1);
        double v = camera->tan_y * ((i / ACROSS + 0.5) * 2 / DOWN - 1);
        Vec3 way =
            vec3_add(camera->forward, vec3_add(vec3_scale(camera->right, u), vec3_scale(camera->up, v)));
        double b = light_at(end_in_room(camera->eye, way));
        double angle = pow(vec3_dot(way, way), -1.5);  // of a pixel
        weight += angle * sqrt(b);
        logs += angle * sqrt(b) * log(b);
    }
    return exp(logs / weight);
}

// Proves that the meter is what its paper's mean is over the view, each direction weighted by the root of its light: half and half
// in closed form, and uneven light pixel by pixel. 4 %: elements of an eighth of a metre are in view or not as a whole (3.4 % today).
Test(exposure, weighs_by_solid_angle_and_root) {
    enum { SIDES = 6 };  // the objects of the left room
    static double (*const LIGHTS[])(Vec3) = {by_side, by_wall, by_floor, by_place};
    Seen s = open_rooms(0.125);
    for (int k = 0; k < 4; k++) {
        for (int e = 0; e < s.lit->mesh.element_count; e++) {
            const float *place = s.mesh->spot[e];
            Vec3 p = vec3_add(s.mesh->origin, vec3((double)place[0], (double)place[1], (double)place[2]));
            for (int c = 0; c < 3; c++) s.solution.radiosity[e][c] = LIGHTS[k](p);
        }
        lit_light_fill(s.mesh, &s.solution, NULL, &s.light);
        for (int turn = 0; turn < 8; turn++) {
            Camera camera = camera_look(vec3(2, 2, 1.6), M_PI / 4 * turn, 0.1 * (turn - 4), 1.4, 160, 90);
            double want = oracle(&camera, LIGHTS[k]);
            double got = exposure_meter(s.mesh, &s.light, &camera, s.objects, SIDES);
            cr_expect_float_eq(got, want, 0.04 * want, "light %d, turn %d: %g instead of %g", k, turn, got,
                               want);
        }
    }
    // Left and right of the view alike: 16 ^ (4 / (4 + 1)).
    for (int e = 0; e < s.lit->mesh.element_count; e++)
        for (int c = 0; c < 3; c++)
            s.solution.radiosity[e][c] = s.mesh->spot[e][1] + s.mesh->origin.y < 2 ? 1 : 16;
    lit_light_fill(s.mesh, &s.solution, NULL, &s.light);
    cr_expect_float_eq(meter(&s, 2, 0), pow(16, 0.8), 1e-4);
    lit_free(s.lit);
}

// Proves that a dark half of the building hardly changes what its level is: by a hundredth.
Test(exposure, the_dark_does_not_count) {
    Seen s = open_rooms(0.5);
    light(&s, 2, 1e-6);
    cr_expect_float_eq(s.light.level, 2, 0.03);
    lit_free(s.lit);
}

// Proves that the eye adapts at once when it opens, then by and by, by the time that passes and not by the frames; that it
// makes up for most of a difference but not for all; that keys add stops; and that fixed it stays.
Test(exposure, adapts_in_time) {
    Exposure a = {0}, b;
    exposure_adapt(&a, 1, 1, 0);
    double before = exposure_scale(&a);
    b = a;
    exposure_adapt(&a, 16, 1, 0.2);
    for (int i = 0; i < 20; i++) exposure_adapt(&b, 16, 1, 0.01);
    cr_expect_float_eq(a.level, b.level, 1e-9 * a.level, "frames do not matter");
    cr_expect(a.level > 1 && a.level < 16);
    for (int i = 0; i < 600; i++) exposure_adapt(&a, 16, 1, 0.01);
    double ratio = before / exposure_scale(&a);
    cr_expect(ratio > 5 && ratio < 16, "16 times the light is exposed %g times less", ratio);
    exposure_adapt(&a, 0, 1, 10);
    cr_expect_float_eq(before / exposure_scale(&a), ratio, 1e-6 * ratio, "where nothing is seen it stays");
    a.stops = 2;
    cr_expect_float_eq(before / exposure_scale(&a), ratio / 4, 1e-6 * ratio);
    a.fixed = true;
    exposure_adapt(&a, 1, 1, 10);
    cr_expect_float_eq(before / exposure_scale(&a), ratio / 4, 1e-6 * ratio, "fixed");
    Exposure dark = {0};
    exposure_adapt(&dark, 1e-12, 1, 0);
    cr_expect_gt(dark.level, 1e-3, "the dark is not made day");
}

// Proves that a tour in its light comes out the same twice, each pixel; in false colours, another tour.
Test(exposure, tours_are_deterministic, .timeout = 300) {
    Arena arena = {0};
    char *folder = support_folder(&arena), *output;
    const char *build = support_build();
    for (int i = 0; i < 3; i++) {
        int code = support_run(
            &arena, &output,
            "export XDG_CACHE_HOME=%s && %s/enfilade walk build/maps/two-rooms.plan --bake --size 96x54 "
            "--offscreen %s/%d --every 7 %s",
            folder, build, folder, i, i == 2 ? "--false-colour illuminance" : "");
        cr_assert_eq(code, 0, "%s", output);
    }
    cr_expect_eq(support_run(&arena, &output, "diff -r %s/0 %s/1", folder, folder), 0, "%s", output);
    cr_expect_neq(support_run(&arena, &output, "diff -rq %s/0 %s/2", folder, folder), 0);
    arena_free(&arena);
}

// Proves that by day an eye in a room adapts to the room, whatever shines outdoors, and an eye outdoors to the outdoors; and that the
// building's level is that of the room. By night the garden behind the window counts.
Test(exposure, rooms_by_day) {
    static const double SKY_RADIANCE[3] = {1, 1, 1};
    Seen s = {.lit = sky_room_with_window(2, 1.5, 0.5)};
    const Mesh *mesh = &s.lit->mesh;
    Arena *arena = &s.lit->arena;
    Error error;
    cr_assert(rad_start_dark(mesh, arena, &s.solution, &error), "%s", error.text);
    s.mesh = lit_mesh_new(mesh, arena, arena);
    s.light = lit_light_new(s.mesh, arena);
    s.objects = ARENA_ARRAY(arena, int, s.lit->graph.object_count);
    for (int o = 0; o < s.lit->graph.object_count; o++) s.objects[o] = o;
    int outdoors = 0;
    for (int e = 0; e < mesh->element_count; e++) {
        outdoors += light_outdoors(mesh, e);
        for (int c = 0; c < 3; c++) s.solution.radiosity[e][c] = light_outdoors(mesh, e) ? 100 : 1;
    }
    cr_assert(outdoors > 0 && outdoors < mesh->element_count);
    for (int day = 0; day < 2; day++) {
        if (day) s.solution.day = daylight_uniform(SKY_RADIANCE);
        lit_light_fill(s.mesh, &s.solution, NULL, &s.light);
        double in_room = meter(&s, 1, 0), in_garden = meter(&s, 6, 0);
        cr_expect_float_eq(in_garden, 100, 1e-3);
        if (day) {
            cr_expect_float_eq(in_room, 1, 1e-5);
            cr_expect_float_eq(s.light.level, 1, 1e-5);
        } else {
            cr_expect(in_room > 1.1 && s.light.level > 1.1, "%g, level %g", in_room, s.light.level);
        }
    }
    lit_free(s.lit);
}

// Proves that what lies outdoors is exposed like all else by night, and where the eye has adapted to outdoors; that in a room which is
// darker it grows brighter on the screen as the day does, without a step, and stays below white although it is a thousand times the room;
// and that the exposure of a room does not depend on it.
Test(exposure, outdoors_through_a_window) {
    static const double ONE[3] = {1, 1, 1};
    Daylight night = {0}, day = daylight_uniform(ONE);
    // A room of level 1 W/m^2.
    Exposure room = {.stops = 0};
    exposure_adapt(&room, 1, 1, 0);
    double scale = exposure_scale(&room), before = 0, level[3];
    cr_expect_eq(exposure_outdoors(scale, &night), scale);
    daylight_horizontal(&day, level);
    for (double brighter = 0.25; brighter < 1000; brighter *= 1.05) {
        Daylight other = day;
        for (int c = 0; c < 3; c++) other.zenith[c] *= brighter;
        double shown = exposure_outdoors(scale, &other) * brighter * level[0];
        cr_expect(shown > before && (before == 0 || shown < 1.051 * before), "%g times: %g, then %g",
                  brighter, before, shown);
        before = shown;
    }
    // A quarter of it, a lawn, is not white.
    cr_expect_lt(exposure_on_screen(before / 4), 0.98);
    Exposure outside = {.stops = 0};
    exposure_adapt(&outside, level[0] / 4, level[0] / 4, 0);
    cr_expect_eq(exposure_outdoors(exposure_scale(&outside), &day), exposure_scale(&outside));
}
