// test_walk.c - nothing visible is lost: tours and random views of real buildings, drawn culled and unculled, and held
// against ray casting and Embree; and tours that reach every cell.
#include <criterion/criterion.h>

#include "engine/walk/tour.h"
#include "engine/walk/verify.h"
#include "maps/maps.h"
#include "tests/embree_oracle.h"
#include "tests/support.h"

typedef struct Walked {
    Arena arena;
    Building building;
    CellGraph graph;
    StabForest forest;
    unsigned char *doors;
} Walked;

static void open_building(Walked *w, const char *path) {
    Error error;
    VisOptions options = vis_default_options();
    *w = (Walked){0};
    cr_assert(maps_read(path, &w->arena, &w->building, &error), "%s", error.text);
    cr_assert(vis_build_cells(&w->building, &options, &w->arena, &w->graph, &error), "%s", error.text);
    cr_assert(vis_build_forest(&w->graph, &options, NULL, &w->arena, &w->forest));
    w->doors = ARENA_ARRAY(&w->arena, unsigned char, w->building.opening_count + 1);
}

static void expect_whole(const VerifyFrame *frame, const char *what, int index, const Camera *c) {
    cr_assert(frame->missing_polygons == 0 && frame->mismatched_pixels == 0,
              "%s %d: %d polygons missing (one is %d), %d pixels differ; eye (%.9g, %.9g, %.9g) looks (%.4f, "
              "%.4f, %.4f)",
              what, index, frame->missing_polygons, frame->missing, frame->mismatched_pixels, c->eye.x,
              c->eye.y, c->eye.z, c->forward.x, c->forward.y, c->forward.z);
}

// Rays decide for themselves what is seen: every polygon they meet is in the draw list of the last frame.
static void expect_rays_agree(Walked *w, WalkVerify *verify, Camera camera, const unsigned char *doors) {
    Arena scratch = {0};
    Error error;
    int *list = ARENA_ARRAY(&scratch, int, w->graph.polygon_count + 1);
    Scene scene = {w->graph.polygons, w->graph.vertices, list,
                   walk_opaque_polygons(&w->graph, doors, &camera.eye, list)};
    camera.width = 160;
    camera.height = 90;
    ItemBuffer items = item_buffer_new(&scratch, camera.width, camera.height);
    void *rays = hidden_find("raycast")->begin(&scene, &scratch, &error);
    cr_assert(rays && hidden_find("raycast")->draw(rays, &camera, &items, &error), "%s", error.text);
    int missing = -1;
    cr_assert_eq(walk_verify_missing(verify, &items, &missing), 0, "ray casting sees polygon %d", missing);
    EmbreeOracle *embree = embree_oracle_new(&scene, camera.eye, &scratch);
    embree_oracle_draw(embree, &camera, &items);
    cr_assert_eq(walk_verify_missing(verify, &items, &missing), 0, "Embree sees polygon %d", missing);
    embree_oracle_free(embree);
    if (hidden_find("raycast")->end) hidden_find("raycast")->end(rays);
    arena_free(&scratch);
}

// Every nth frame of the auto tour (all of them at soak), then random views with random doors; some also by rays.
static void verify_building(const char *path) {
    enum { RAY_FRAMES = 15 };  // of the tour, and as many random views
    Walked w;
    Error error;
    TourPath tour;
    TourOptions options = tour_default_options();
    open_building(&w, path);
    WalkVerify *verify = walk_verify_new(&w.graph, &w.forest, &w.arena, &error);
    cr_assert(verify, "%s", error.text);
    cr_assert(tour_make(&w.graph, "auto", &options, &w.arena, &tour, &error), "%s", error.text);
    int frames = support_count(60, tour.frame_count),
        step = tour.frame_count / frames + (tour.frame_count < frames);
    for (int i = 0, k = 0, cell = -1; i < tour.frame_count; i += step, k++) {
        const TourFrame *f = &tour.frames[i];
        Camera camera = camera_look(f->eye, f->yaw, f->pitch, f->fov, 640, 360);
        VerifyFrame frame;
        cell = vis_locate(&w.graph, f->eye, cell);
        cr_assert(walk_verify_frame(verify, &camera, cell, NULL, VIS_STAB, &frame, &error), "%s", error.text);
        expect_whole(&frame, "frame", i, &camera);
        if (k < RAY_FRAMES) expect_rays_agree(&w, verify, camera, NULL);
    }
    Random random = {1};
    RandomView view = {.door_open = w.doors};
    int views = support_count(100, 2000);
    for (int i = 0; i < views;) {
        VerifyFrame frame;
        if (!walk_random_view(&w.graph, &random, 640, 360, &view)) continue;
        cr_assert(
            walk_verify_frame(verify, &view.camera, view.cell, view.door_open, VIS_STAB, &frame, &error),
            "%s", error.text);
        expect_whole(&frame, view.kind, i, &view.camera);
        if (i < RAY_FRAMES) expect_rays_agree(&w, verify, view.camera, view.door_open);
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
    verify_building(support_shared("sh3d/2BedroomHouseWithBasement.Home.xml"));
}
Test(verify, apartment, .timeout = 900) {
    verify_building(support_shared("sh3d/3BedroomApartment.Home.xml"));
}
Test(verify, four_bedrooms, .timeout = 900) { verify_building(support_shared("sh3d/4-BedroomHouse.sh3d")); }

// Proves that the check above can fail: with one object taken from the draw list its polygons are missed.
Test(verify, notices_what_is_lost) {
    Walked w;
    Error error;
    open_building(&w, "build/maps/two-rooms.plan");
    WalkVerify *verify = walk_verify_new(&w.graph, &w.forest, &w.arena, &error);
    cr_assert(verify, "%s", error.text);
    Camera camera = camera_look(w.building.start, w.building.start_yaw, 0, 1.2, 320, 180);
    int cell = vis_locate(&w.graph, camera.eye, -1);
    VerifyFrame frame;
    cr_assert(walk_verify_frame(verify, &camera, cell, NULL, VIS_STAB, &frame, &error));
    expect_whole(&frame, "start", 0, &camera);
    // The eye's cell given wrong, a frame of what another cell sees: the walls around the eye are lost.
    int other = -1;
    for (int c = 0; c < w.graph.cell_count && other < 0; c++) {
        if (!vis_sees(&w.forest, cell, c)) other = c;
    }
    for (int c = 0; c < w.graph.cell_count && other < 0; c++) {
        if (c != cell && w.building.regions[w.graph.cells[c].region].kind == REGION_ROOM) other = c;
    }
    cr_assert(walk_verify_frame(verify, &camera, other, NULL, VIS_STAB, &frame, &error));
    cr_assert_gt(frame.missing_polygons, 0);
    cr_assert_gt(frame.mismatched_pixels, 0);
    walk_verify_free(verify);
    arena_free(&w.arena);
}

// Proves that the auto tour keeps its steps, stays in free space and visits the rooms, and is the same every time.
Test(tour, visits_every_room) {
    static const char *const paths[] = {"build/maps/two-rooms.plan", "build/maps/house.plan",
                                        "build/maps/office.plan"};
    for (int k = 0; k < 3; k++) {
        Walked w;
        Error error;
        TourPath tour, again;
        TourOptions options = tour_default_options();
        open_building(&w, paths[k]);
        cr_assert(tour_make(&w.graph, "auto", &options, &w.arena, &tour, &error), "%s", error.text);
        cr_assert(tour_make(&w.graph, "auto", &options, &w.arena, &again, &error), "%s", error.text);
        cr_assert_eq(tour.frame_count, again.frame_count);
        cr_assert_eq(memcmp(tour.frames, again.frames, (size_t)tour.frame_count * sizeof *tour.frames), 0);
        for (int i = 0; i < tour.frame_count; i++) {
            cr_assert_geq(vis_locate(&w.graph, tour.frames[i].eye, -1), 0, "%s: frame %d is outside",
                          paths[k], i);
            if (i == 0) continue;
            double step = vec3_length(vec3_sub(tour.frames[i].eye, tour.frames[i - 1].eye));
            cr_assert_leq(step, options.step + 1e-9, "%s: frame %d goes %.3f m", paths[k], i, step);
        }
        int rooms = 0, visited = 0;
        for (int c = 0; c < w.graph.cell_count; c++) {
            if (w.building.regions[w.graph.cells[c].region].kind != REGION_ROOM || !tour.reachable[c])
                continue;
            rooms++;
            visited += tour.visited[c];
        }
        cr_assert(rooms > 1 && visited == rooms, "%s: %d of %d room cells are visited", paths[k], visited,
                  rooms);
        cr_assert_not(tour_make(&w.graph, "no such tour", &options, &w.arena, &again, &error));
        arena_free(&w.arena);
    }
}
