// test_tour.c - tours, pictures and videos of a walk.
#include <criterion/criterion.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include "engine/draw/image.h"
#include "engine/tour/tour.h"
#include "engine/tour/tour_floor.h"
#include "engine/walk/video.h"
#include "engine/walk/walk_offscreen.h"
#include "tests/support/support.h"
#include "tests/walk/walk_fixture.h"

// Proves that the auto tour stays in free space, is in every room that a body can enter, and is the same every time.
Test(tour, visits_every_room, .timeout = 120) {
    static const char *const paths[] = {"build/maps/two-rooms.plan", "build/maps/house.plan",
                                        "build/maps/office.plan"};
    // One room of the house is a shower too small to take a step in.
    static const int rooms[] = {2, 10, 83};
    for (int k = 0; k < 3; k++) {
        Walked w;
        Error error;
        TourPath tour, again;
        TourOptions options = tour_default_options();
        walk_check_open_building(&w, paths[k]);
        cr_assert(tour_make(&w.graph, "auto", &options, &w.arena, &tour, &error), "%s", error.text);
        cr_assert(tour_make(&w.graph, "auto", &options, &w.arena, &again, &error), "%s", error.text);
        cr_assert_eq(tour.frame_count, again.frame_count);
        cr_assert_eq(memcmp(tour.frames, again.frames, (size_t)tour.frame_count * sizeof *tour.frames), 0);
        unsigned char *seen = ARENA_ARRAY(&w.arena, unsigned char, w.building.region_count + 1);
        int entered = 0;
        for (int i = 0, cell = -1; i < tour.frame_count; i++) {
            cell = vis_locate(&w.graph, tour.frames[i].eye, cell);
            cr_assert_geq(cell, 0, "%s: frame %d is outside", paths[k], i);
            const Region *region = vis_region(&w.graph, cell);
            if (region->kind == REGION_ROOM) seen[region - w.building.regions] = 1;
        }
        for (int r = 0; r < w.building.region_count; r++) entered += seen[r];
        cr_expect_geq(entered, rooms[k], "%s: frames are in %d rooms", paths[k], entered);
        cr_expect(tour.rooms_entered == rooms[k] && tour.rooms_enterable == rooms[k], "%s: %d of %d rooms",
                  paths[k], tour.rooms_entered, tour.rooms_enterable);
        cr_assert_not(tour_make(&w.graph, "no such tour", &options, &w.arena, &again, &error));
        arena_free(&w.arena);
    }
}

// Proves that the eye stays out of walls in a building so large that the columns of the floor are farther apart than a body is wide: there
// clearance is a guess, and the line was smoothed into walls (158 of 51,000 moments of a tour of 196 rooms).
Test(tour, of_a_large_building, .timeout = 300) {
    Walked w;
    Error error;
    Arena arena = {0};
    TourPath tour;
    TourFloor floor;
    TourOptions options = tour_default_options();
    char *path = arena_format(&arena, "%s/campus.plan", support_folder(&arena)), *output;
    cr_assert_eq(support_run(&arena, &output, "build/generate campus-316 1 > %s", path), 0, "%s", output);
    walk_check_open_building(&w, path);
    options.rooms = 200;
    tour_floor_make(&w.graph, options.rooms, &arena, &floor);
    cr_assert_gt(floor.apart, BODY_RADIUS);
    cr_assert(tour_make(&w.graph, "auto", &options, &w.arena, &tour, &error), "%s", error.text);
    int outside = 0;
    for (int i = 0, cell = -1; i < tour.film.moment_count; i++) {
        cell = vis_locate(&w.graph, tour.film.moments[i].eye, cell);
        outside += cell < 0;
    }
    cr_expect_eq(outside, 0, "%d of %d moments", outside, tour.film.moment_count);
    cr_expect(tour.rooms_enterable > 150 && tour.rooms_entered == tour.rooms_enterable, "%d of %d rooms",
              tour.rooms_entered, tour.rooms_enterable);
    arena_free(&w.arena);
    arena_free(&arena);
}

// Proves that the floor of a tour knows every place whose eye is in a piece of furniture, or near to one: each piece is asked about each
// place, and the floor says so of no place farther off than it keeps from things, 12 cm.
Test(tour, knows_places_in_furniture) {
    Walked w;
    TourFloor floor;
    int in_things = 0;
    walk_check_open_building(&w, "build/maps/house.plan");
    tour_floor_make(&w.graph, 0, &w.arena, &floor);
    for (int i = 0; i < floor.place_count; i++) {
        const FloorPlace *p = &floor.places[i];
        Vec3 eye = vec3(p->foot.x, p->foot.y, p->foot.z + (double)p->eye);
        bool told = p->unfit & FLOOR_IN_THINGS;
        cr_assert(told || !tour_floor_in_things(&w.building, eye, 0), "place %d is in a thing", i);
        cr_assert(!told || tour_floor_in_things(&w.building, eye, 0.13), "place %d is in none", i);
        in_things += told;
    }
    cr_assert_gt(in_things, 100, "%d of %d places", in_things, floor.place_count);
    arena_free(&w.arena);
}

// Proves that a tour of some rooms goes into those and no others: as many as asked for, the start's among them, each reached from
// there through rooms that the tour enters, and all frames in them, in doorways and on stairs between.
Test(tour, of_some_rooms) {
    Walked w;
    Error error;
    walk_check_open_building(&w, "build/maps/office-plain.plan");
    for (int rooms = 1; rooms <= 17; rooms += 8) {
        TourOptions options = tour_default_options();
        TourPath tour;
        options.rooms = rooms;
        cr_assert(tour_make(&w.graph, "auto", &options, &w.arena, &tour, &error), "%s", error.text);
        unsigned char *seen = ARENA_ARRAY(&w.arena, unsigned char, w.building.region_count + 1);
        int entered = 0;
        for (int i = 0, cell = -1; i < tour.frame_count; i++) {
            cell = vis_locate(&w.graph, tour.frames[i].eye, cell);
            cr_assert_geq(cell, 0, "frame %d is outside", i);
            if (vis_region(&w.graph, cell)->kind == REGION_ROOM) seen[w.graph.cells[cell].region] = 1;
        }
        for (int r = 0; r < w.building.region_count; r++) entered += seen[r];
        cr_assert_eq(entered, rooms, "%d rooms of %d", entered, rooms);
        cr_assert(tour.rooms_entered == rooms && tour.rooms_enterable == rooms && tour.note_count == 0,
                  "%d of %d rooms, %d notes", tour.rooms_entered, tour.rooms_enterable, tour.note_count);
        int start = vis_locate(&w.graph, w.building.start, -1);
        cr_assert(seen[w.graph.cells[start].region], "the start's room is not among them");
    }
    arena_free(&w.arena);
}

// Proves that stored tours pass through each of their viewpoints, no faster than asked; that a viewpoint is a tour of
// one frame; and that any other name is refused with those there are.
Test(tour, stored_ones) {
    Walked w;
    Error error = {""};
    TourOptions options = tour_default_options();
    TourPath path;
    walk_check_open_building(&w, "build/maps/two-rooms.plan");
    const Building *b = &w.building;
    cr_assert(b->tour_count > 0 && b->viewpoint_count > 0, "the sample has a tour and a viewpoint");
    cr_assert(tour_make(&w.graph, b->tours[0].name, &options, &w.arena, &path, &error), "%s", error.text);
    for (int i = 0; i < b->tours[0].viewpoint_count; i++) {
        const Viewpoint *v = &b->tour_points[b->tours[0].first_viewpoint + i];
        double nearest = INFINITY;
        for (int k = 0; k < path.frame_count; k++) {
            nearest = fmin(nearest, vec3_length(vec3_sub(path.frames[k].eye, v->eye)));
        }
        cr_assert(nearest < 1e-9, "viewpoint %d is missed by %g m", i, nearest);
    }
    for (int k = 1; k < path.frame_count; k++) {
        const TourFrame *f = &path.frames[k - 1];
        cr_assert(vec3_length(vec3_sub(f[1].eye, f[0].eye)) <= options.step + 1e-9);
        cr_assert(fabs(remainder(f[1].yaw - f[0].yaw, 2 * M_PI)) <= options.turn + 1e-9);
    }
    cr_assert(tour_make(&w.graph, b->viewpoints[0].name, &options, &w.arena, &path, &error), "%s",
              error.text);
    cr_assert(path.frame_count == 1 && vec3_equal(path.frames[0].eye, b->viewpoints[0].eye));
    cr_assert_not(tour_make(&w.graph, "no such tour", &options, &w.arena, &path, &error));
    cr_assert(strstr(error.text, "`no such tour`") && strstr(error.text, b->tours[0].name), "%s", error.text);
    arena_free(&w.arena);
}

// Proves that a PNG comes back as it went, and that a place that cannot be written is named.
Test(walk, png) {
    enum { WIDTH = 37, HEIGHT = 21 };
    Arena arena = {0};
    Error error = {""};
    char *path = arena_format(&arena, "%s/image.png", support_folder(&arena));
    uint8_t rgb[WIDTH * HEIGHT * 3], *back = NULL;
    Random random = {5};
    for (int i = 0; i < WIDTH * HEIGHT * 3; i++) rgb[i] = (uint8_t)random_index(&random, 256);
    int width, height;
    cr_assert(image_write_png(path, rgb, WIDTH, HEIGHT, &error), "%s", error.text);
    cr_assert(image_read_png(path, &arena, &back, &width, &height, &error), "%s", error.text);
    cr_assert(width == WIDTH && height == HEIGHT && memcmp(rgb, back, sizeof rgb) == 0);
    cr_assert_not(image_write_png("/nowhere/at/all.png", rgb, WIDTH, HEIGHT, &error));
    cr_assert(strstr(error.text, "/nowhere/at/all.png"), "%s", error.text);
    arena_free(&arena);
}

// Proves that a video of odd size is made, through no link that lies in wait beside it; and that without ffmpeg, or when it fails,
// one sentence says so, an earlier file stays as it was, and nothing is left beside it.
Test(walk, video, .timeout = 60) {
    enum { WIDTH = 65, HEIGHT = 33 };
    static uint8_t rgb[WIDTH * HEIGHT * 3];
    // Says much before the last line, which tells why; takes no frame.
    static const char fake[] = "#!/bin/sh\nfor i in 1 2 3 4 5 6 7 8 9; do\n  echo $i, of which nobody asked: "
                               "a line that is as long as those of ffmpeg are now and then >&2\ndone\n"
                               "echo no such codec >&2\nexit 3\n";
    Arena arena = {0};
    Error error = {""};
    if (support_run(&arena, NULL, "command -v ffmpeg >/dev/null") != 0) cr_skip_test("ffmpeg is not here");
    const char *folder = support_folder(&arena), *usual = arena_string(&arena, getenv("PATH"));
    char *path = arena_format(&arena, "%s/film.mp4", folder),
         *others = arena_format(&arena, "%s/others", folder);
    // Where a link may lie in wait.
    const char *traps[] = {arena_format(&arena, "%s.enfilade-0", path),
                           arena_format(&arena, "%s.%d.part", path, (int)getpid())};
    cr_assert(file_write(others, "mine", 4, &error), "%s", error.text);
    for (int i = 0; i < 2; i++) cr_assert_eq(symlink(others, traps[i]), 0);
    Video *video = video_begin(path, WIDTH, HEIGHT, 10, 1, &arena, &error);
    cr_assert(video, "%s", error.text);
    for (int i = 0; i < 5; i++) {
        memset(rgb, 50 * i, sizeof rgb);
        cr_assert(video_add(video, rgb, &error), "%s", error.text);
    }
    cr_assert(video_end(video, &error), "%s", error.text);
    Bytes film = support_read(&arena, path);
    cr_assert(film.size > 8 && memcmp(film.data + 4, "ftyp", 4) == 0, "not an MP4");
    cr_expect_eq(support_read(&arena, others).size, 4, "a planted link was written through");
    cr_assert(unlink(traps[0]) == 0 && unlink(traps[1]) == 0 && unlink(others) == 0);

    setenv("PATH", folder, 1);
    cr_assert_null(video_begin(path, WIDTH, HEIGHT, 10, 1, &arena, &error));
    cr_assert(strstr(error.text, "ffmpeg cannot be started"), "%s", error.text);
    char *program = arena_format(&arena, "%s/ffmpeg", folder);
    cr_assert(file_write(program, fake, sizeof fake - 1, &error), "%s", error.text);
    chmod(program, 0755);
    video = video_begin(path, WIDTH, HEIGHT, 10, 1, &arena, &error);
    cr_assert(video, "%s", error.text);
    bool good = true;
    for (int i = 0; i < 100 && good; i++) good = video_add(video, rgb, &error);
    cr_assert(!good && strstr(error.text, "no such codec"), "%s", error.text);
    cr_assert_not(video_end(video, &error));
    cr_assert(strstr(error.text, "no such codec"), "%s", error.text);
    setenv("PATH", usual, 1);
    Bytes still = support_read(&arena, path);
    cr_assert(still.size == film.size && memcmp(still.data, film.data, film.size) == 0, "the film is gone");
    cr_assert_eq(support_run(&arena, NULL, "test \"$(ls %s | wc -l)\" = 2", folder), 0, "something is left");
    arena_free(&arena);
}

// Proves that a tour off-screen leaves each second frame as a picture of the size asked for with something in it, and
// a line of statistics a frame; and that one that fails leaves earlier statistics alone.
Test(walk, offscreen, .timeout = 120) {
    Walked w;
    Error error = {""};
    walk_check_open_building(&w, "build/maps/two-rooms.plan");
    const char *folder = support_folder(&w.arena);
    WalkOptions options = walk_default_options();
    options.folder = arena_format(&w.arena, "%s/frames", folder);
    options.stats = arena_format(&w.arena, "%s/stats.csv", folder);
    options.tour = w.building.tours[0].name;
    options.width = 160;
    options.height = 90;
    options.every = 2;
    WalkTotals totals;
    cr_assert(walk_offscreen(&w.graph, &w.forest, &options, NULL, &w.arena, &totals, &error), "%s",
              error.text);
    cr_assert(totals.frames > 2 && totals.images == (totals.frames + 1) / 2);
    cr_assert(totals.polygons_drawn_mean > 0 && totals.polygons_drawn_mean <= totals.polygons_total);
    uint8_t *rgb = NULL;
    int width, height, differing = 0, lines = 0;
    char *path = arena_format(&w.arena, "%s/frame-%05d.png", options.folder, totals.images - 1);
    cr_assert(image_read_png(path, &w.arena, &rgb, &width, &height, &error), "%s", error.text);
    cr_assert(width == 160 && height == 90);
    for (int i = 3; i < width * height * 3; i++) differing += rgb[i] != rgb[i - 3];
    cr_assert(differing > 1000, "the picture is blank");
    Bytes stats = support_read(&w.arena, options.stats);
    for (size_t i = 0; i < stats.size; i++) lines += stats.data[i] == '\n';
    cr_assert_eq(lines, totals.frames + 1);
    options.tour = "no such tour";
    cr_assert_not(walk_offscreen(&w.graph, &w.forest, &options, NULL, &w.arena, &totals, &error));
    cr_assert_eq(support_read(&w.arena, options.stats).size, stats.size);
    arena_free(&w.arena);
}

// Proves that culling changes no pixel of the picture that is looked at: shaded, antialiased, with glass.
Test(walk, pictures_are_the_same_culled, .timeout = 120) {
    Walked w;
    Error error = {""};
    WalkTotals totals;
    const char *folder[2];
    walk_check_open_building(&w, "build/maps/house.plan");
    for (int k = 0; k < 2; k++) {
        WalkOptions options = walk_default_options();
        options.folder = folder[k] = support_folder(&w.arena);
        options.width = 96;
        options.height = 54;
        options.every = 25;
        options.culling = k ? CULL_NONE : CULL_STAB;
        cr_assert(walk_offscreen(&w.graph, &w.forest, &options, NULL, &w.arena, &totals, &error), "%s",
                  error.text);
    }
    cr_assert_gt(totals.images, 10);
    for (int i = 0; i < totals.images; i++) {
        uint8_t *image[2];
        int width = 0, height = 0;
        for (int k = 0; k < 2; k++) {
            char *path = arena_format(&w.arena, "%s/frame-%05d.png", folder[k], i);
            cr_assert(image_read_png(path, &w.arena, &image[k], &width, &height, &error), "%s", error.text);
        }
        cr_assert_eq(memcmp(image[0], image[1], (size_t)width * (size_t)height * 3), 0, "picture %d differs",
                     i);
    }
    arena_free(&w.arena);
}
