// test_lit_frames.c - frames of lit buildings, looked at and kept: corners, feet of furniture, frames of doors, sills of windows and
// stairs, where light meets seams. What is drawn now is held against tests/references.
//
// ENFILADE_KEEP=1 takes the references anew: look at them before they are committed.
#include <criterion/criterion.h>
#include <stdio.h>
#include <stdlib.h>

#include "engine/draw/image.h"
#include "engine/draw/view.h"
#include "engine/draw/walk_renderer.h"
#include "engine/gl/gl_context.h"
#include "radiosity/show/direct.h"
#include "radiosity/show/fine_mesh.h"
#include "radiosity/show/shown.h"
#include "tests/support/baked_fixture.h"
#include "tests/support/support.h"

enum { WIDTH = 480, HEIGHT = 270, CHANNELS = 3 * WIDTH * HEIGHT };
// References are kept in steps of so many levels: the files are a quarter as large.
enum { STEP = 8 };

typedef struct LitView {
    const char *name;
    Vec3 eye;
    double yaw, pitch, fov;  // degrees
    double stops;            // on top of what the eye adapts to
} LitView;

static const LitView TWO_ROOMS[] = {{"door", {0.6, 3, 1.6}, -50, -12, 75, 0},
                                    {"leg", {6.6, 1.4, 0.35}, -30, -42, 40, 0},
                                    {"corner", {2, 1.75, 1.6}, 158, 25, 80, 0},
                                    {0}};
static const LitView HOUSE[] = {
    {"bed", {2.7, 5.11, 4.5}, -179, -40, 60, 0},     {"wardrobe", {10.66, 1.8, 4.5}, 114, -12, 80, 0},
    {"sill", {2.7, 1.8, 4.5}, -29, -12, 80, 0},      {"stairs", {6.4, 6.1, 1.6}, 95, -28, 75, 0},
    {"worktop", {10.66, 3.25, 1.6}, -134, 5, 80, 0}, {0}};
static const LitView OFFICE_PLAIN[] = {{"desk", {2, 2, 1.6}, 45, -30, 80, 0},
                                       {"partition", {18.4, 18.4, 1.6}, -120, -12, 80, 0},
                                       {"enfilade", {34.8, 4.6, 1.6}, 90, -30, 80, 0},
                                       {0}};
static const LitView OFFICE[] = {{"corridor", {3, 5.5, 1.6}, 0, -30, 80, 0},
                                 {"shelves", {29.6, 21, 1.6}, 122.7, -12, 80, 0},
                                 {"desks", {4.81, 48.4, 1.6}, -97.4, -30, 80, 0},
                                 {0}};
// Homes, of Sweet Home 3D: ours.
static const LitView FLAT[] = {{"boxes", {4.2, 0.5, 1.6}, 140, -14, 80, 0},
                               {"kitchen", {3.3, 5.2, 1.6}, 118, -14, 80, 0},
                               {"corner", {11.0, 5.2, 1.6}, 170, -8, 80, 0},
                               {0}};
static const LitView HILLSIDE[] = {{"dining", {9.4, 5.4, 2.35}, 235, -12, 80, 0},
                                   {"roof", {3.9, 6.6, 5.2}, 235, -10, 80, 0},
                                   {"shelves", {3.6, 1.6, -0.4}, 130, -12, 80, 0},
                                   {0}};

static void keep(const char *path, const uint8_t *rgb, Arena *arena) {
    Error error;
    uint8_t *rough = ARENA_ARRAY(arena, uint8_t, CHANNELS);
    for (int i = 0; i < CHANNELS; i++) {
        int level = (rgb[i] + STEP / 2) / STEP * STEP;
        rough[i] = (uint8_t)(level > 255 ? 255 : level);
    }
    cr_assert(image_write_png(path, rough, WIDTH, HEIGHT, &error), "%s", error.text);
}

static uint8_t *draw(const BakedBuilding *b, WalkRenderer *renderer, const LitView *view, Arena *arena) {
    Error error;
    const double DEGREE = M_PI / 180;
    Camera camera =
        camera_look(view->eye, view->yaw * DEGREE, view->pitch * DEGREE, view->fov * DEGREE, WIDTH, HEIGHT);
    Eye eye = walk_eye(&camera);
    VisQuery *query = vis_query_new(&b->scene.graph, &b->scene.forest, arena);
    int cell = vis_locate(&b->scene.graph, camera.eye, -1);
    VisResult v = vis_query(query, &eye, cell, b->doors, CULL_STAB);
    Exposure exposure = {.stops = view->stops};
    const LitLight *light = walk_renderer_lit(renderer);
    double seen = exposure_meter(walk_renderer_mesh(renderer), light, &camera, v.objects, v.object_count);
    exposure_adapt(&exposure, seen, light->level, 0);
    walk_renderer_tone(renderer, exposure_scale(&exposure), FALSE_COLOUR_OFF);
    walk_renderer_pose(renderer, b->doors);
    uint8_t *rgb = ARENA_ARRAY(arena, uint8_t, CHANNELS);
    cr_assert(walk_renderer_draw(renderer, &camera, v.objects, v.object_count, WALK_BAKED, &error) &&
                  walk_renderer_finish_scene(renderer, &error) && walk_renderer_read(renderer, rgb, &error),
              "%s", error.text);
    return rgb;
}

// Alike by pixels, means, structure and sharpness: compare_pictures.py says how far, and is checked itself by check_render.sh.
static void compare(const char *reference, const uint8_t *rgb, Arena *arena) {
    Error error;
    char *drawn = arena_format(arena, "%s/drawn.png", support_folder(arena)), *said;
    cr_assert(image_write_png(drawn, rgb, WIDTH, HEIGHT, &error), "%s", error.text);
    int status = support_run(arena, &said, "python3 tests/app/compare_pictures.py --step %d %s %s", STEP,
                             drawn, reference);
    cr_expect_eq(status, 0, "%s: %s", reference, said);
}

static void check(const char *file, const char *building, const LitView *views) {
    Error error;
    BakedBuilding *b = baked_building(file, 0);
    GlContext *context = gl_context_open(&b->arena, &error);
    cr_assert(context, "%s", error.text);
    WalkRenderer *renderer = walk_renderer_new(&b->scene.graph, &b->arena, &error);
    cr_assert(renderer, "%s", error.text);
    // As the walk shows it: on the finer mesh, fine furniture lit from its stand-ins.
    const Mesh *mesh;
    const RadSolution *solution;
    cr_assert(direct_show(&b->mesh, &b->scene.forest, b->doors, 0, NULL, &b->arena, &b->solution, NULL));
    cr_assert(shown_light(&b->mesh, &b->solution, b->doors, &b->arena, &mesh, &solution, &error), "%s",
              error.text);
    FineMesh *fine = fine_mesh_new(mesh, &b->arena);
    RadSolution shown = fine_light(fine, solution, &b->arena);
    WalkLight light = {.mesh = &fine->mesh, .solution = &shown, .door_open = b->doors, .fine = fine};
    cr_assert(walk_renderer_light(renderer, &light, &b->arena, &error), "%s", error.text);
    for (; views->name; views++) {
        Arena scratch = {0};
        const char *path = arena_format(&scratch, "tests/references/lit-%s-%s.png", building, views->name);
        const uint8_t *rgb = draw(b, renderer, views, &scratch);
        if (getenv("ENFILADE_KEEP")) keep(path, rgb, &scratch);
        compare(path, rgb, &scratch);
        arena_free(&scratch);
    }
    walk_renderer_free(renderer);
    gl_context_close(context);
    baked_building_free(b);
}

// Proves that what is shown of the light of the samples is what was looked at and found free of cracks, dark or bright patches.
Test(lit_frames, two_rooms, .timeout = 200) { check("build/maps/two-rooms.plan", "two-rooms", TWO_ROOMS); }
Test(lit_frames, house, .timeout = 300) { check("build/maps/house.plan", "house", HOUSE); }

// Large ones: make soak.
Test(lit_frames, office_plain, .timeout = 600) {
    if (!support_count(0, 1)) cr_skip_test("its bake takes half a minute with others beside it: make soak");
    check("build/maps/office-plain.plan", "office-plain", OFFICE_PLAIN);
}
Test(lit_frames, office, .timeout = 600) {
    if (!support_count(0, 1)) cr_skip_test("its bake takes half a minute with others beside it: make soak");
    check("build/maps/office.plan", "office", OFFICE);
}

Test(lit_frames, flat, .timeout = 300) { check("build/maps/flat.Home.xml", "flat", FLAT); }
Test(lit_frames, hillside, .timeout = 900) {
    if (!support_count(0, 1)) cr_skip_test("its bake takes half a minute: make soak");
    check("build/maps/hillside.sh3d", "hillside", HILLSIDE);
}
