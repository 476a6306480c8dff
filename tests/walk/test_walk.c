// test_walk.c - nothing visible is lost: tours and random views of real buildings, drawn culled and unculled, and held
// against ray casting and Embree; tours that reach every cell; pictures and videos that arrive whole.
#include <criterion/criterion.h>

#include "engine/tour/tour.h"
#include "engine/walk/verify.h"
#include "tests/support/support.h"
#include "tests/walk/walk_fixture.h"

static void expect_whole(const VerifyFrame *frame, const char *what, int index, const Camera *c) {
    cr_assert(frame->missing_polygons == 0 && frame->mismatched_pixels == 0,
              "%s %d: %d polygons missing (one is %d), %d pixels differ; eye (%.9g, %.9g, %.9g) looks (%.4f, "
              "%.4f, %.4f)",
              what, index, frame->missing_polygons, frame->missing, frame->mismatched_pixels, c->eye.x,
              c->eye.y, c->eye.z, c->forward.x, c->forward.y, c->forward.z);
}

// Rays decide for themselves what is seen: every polygon they meet is in the draw list of the last frame.
static void expect_rays_agree(Walked *w, WalkVerify *verify, Camera camera, const float *doors) {
    Arena scratch = {0};
    Error error;
    int *list = ARENA_ARRAY(&scratch, int, w->graph.polygon_count + 1);
    Scene scene = {w->graph.polygons, walk_verify_vertices(verify), list,
                   walk_opaque_polygons(&w->graph, doors, &camera.eye, list)};
    camera.width = 160;
    camera.height = 90;
    ItemBuffer items = item_buffer_new(&scratch, camera.width, camera.height);
    static const char *const METHODS[] = {"raycast", "embree"};
    for (int m = 0; m < 2; m++) {
        const HiddenMethod *method = hidden_find(METHODS[m]);
        void *rays = method->begin(&scene, &scratch, &error);
        cr_assert(rays && hidden_draw(method, rays, &camera, &items, NULL, &error), "%s", error.text);
        int missing = -1;
        cr_assert_eq(walk_verify_missing(verify, &items, &missing), 0, "%s sees polygon %d", METHODS[m],
                     missing);
        if (method->end) method->end(rays);
    }
    arena_free(&scratch);
}

// Every nth frame of the auto tour (all of them at soak), then random views with random doors; some also by rays.
static void verify_building(const char *path) {
    Walked w;
    Error error;
    TourPath tour;
    TourOptions options = tour_default_options();
    walk_check_open_building(&w, path);
    WalkVerify *verify = walk_verify_new(&w.graph, &w.forest, &w.arena, &error);
    cr_assert(verify, "%s", error.text);
    cr_assert(tour_make(&w.graph, "auto", &options, &w.arena, &tour, &error), "%s", error.text);
    int ray_frames = support_count(6, 15);  // of the tour, and as many random views
    int frames = support_count(30, tour.frame_count),
        step = tour.frame_count / frames + (tour.frame_count < frames);
    for (int i = 0, k = 0, cell = -1; i < tour.frame_count; i += step, k++) {
        const TourFrame *f = &tour.frames[i];
        Camera camera = camera_look(f->eye, f->yaw, f->pitch, f->fov, 640, 360);
        VerifyFrame frame;
        cell = vis_locate(&w.graph, f->eye, cell);
        cr_assert(walk_verify_frame(verify, &camera, cell, NULL, CULL_STAB, &frame, &error), "%s",
                  error.text);
        expect_whole(&frame, "frame", i, &camera);
        if (k < ray_frames) expect_rays_agree(&w, verify, camera, NULL);
    }
    Random random = {1};
    RandomView view = {.door_open = w.doors};
    int views = support_count(50, 2000);
    for (int i = 0; i < views;) {
        VerifyFrame frame;
        if (!walk_random_view(&w.graph, &random, 640, 360, &view)) continue;
        cr_assert(
            walk_verify_frame(verify, &view.camera, view.cell, view.door_open, CULL_STAB, &frame, &error),
            "%s", error.text);
        expect_whole(&frame, view.kind, i, &view.camera);
        if (i < ray_frames) expect_rays_agree(&w, verify, view.camera, view.door_open);
        i++;
    }
    walk_verify_free(verify);
    arena_free(&w.arena);
}

Test(verify, two_rooms, .timeout = 900) { verify_building("build/maps/two-rooms.plan"); }

Test(verify, house, .timeout = 900) { verify_building("build/maps/house.plan"); }

Test(verify, house_sh3d, .timeout = 900) { verify_building("build/maps/house.sh3d"); }

Test(verify, office, .timeout = 900) { verify_building("build/maps/office.plan"); }

Test(verify, office_plain, .timeout = 900) { verify_building("build/maps/office-plain.plan"); }

Test(verify, home_with_basement, .timeout = 900) {
    verify_building(support_either("sh3d/2BedroomHouseWithBasement.Home.xml", "build/maps/hillside.sh3d"));
}

Test(verify, apartment, .timeout = 900) {
    verify_building(support_either("sh3d/3BedroomApartment.Home.xml", "build/maps/flat.Home.xml"));
}

Test(verify, four_bedrooms, .timeout = 900) {
    verify_building(support_either("sh3d/4-BedroomHouse.sh3d", "build/maps/villa.sh3d"));
}

// Proves that the check above can fail: where the eye's cell is said to see itself alone, what lies beyond its portals is lost.
Test(verify, notices_what_is_lost) {
    Walked w;
    Error error;
    walk_check_open_building(&w, "build/maps/two-rooms.plan");
    WalkVerify *verify = walk_verify_new(&w.graph, &w.forest, &w.arena, &error);
    cr_assert(verify, "%s", error.text);
    Vec3 eye = w.building.start;
    int cell = vis_locate(&w.graph, eye, -1), missing = 0, mismatched = 0;
    uint64_t *alone = ARENA_ARRAY(&w.arena, uint64_t, w.forest.words);
    alone[cell / 64] |= (uint64_t)1 << (cell % 64);
    for (int lossy = 0; lossy < 2; lossy++) {
        for (int i = 0; i < 8; i++) {
            Camera camera = camera_look(eye, i * M_PI / 4, 0, 1.2, 320, 180);
            VerifyFrame frame;
            cr_assert(walk_verify_frame(verify, &camera, cell, NULL, CULL_STAB, &frame, &error));
            if (!lossy) expect_whole(&frame, "start", i, &camera);
            missing += frame.missing_polygons;
            mismatched += frame.mismatched_pixels;
        }
        // Without its tree, portals are walked, within what the cell is said to see.
        w.forest.bounded[cell] = 1;
        cell_rows_set(&w.forest.seen, cell, alone, &w.arena);
        if (lossy) break;
        walk_verify_free(verify);
        verify = walk_verify_new(&w.graph, &w.forest, &w.arena, &error);
        cr_assert(verify, "%s", error.text);
    }
    cr_assert_gt(missing, 0);
    cr_assert_gt(mismatched, 0);
    walk_verify_free(verify);
    arena_free(&w.arena);
}
