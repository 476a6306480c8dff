// test_renderer.c - the walk's renderer: culling changes no pixel, doors stand where they should, what others leave
// behind in OpenGL does no harm, the final frame is upright; and the light that is baked: no seams, lamps, corners.
#include <criterion/criterion.h>
#include <glad/gl.h>

#include "engine/draw/view.h"
#include "engine/draw/walk_renderer.h"
#include "engine/gl/gl_context.h"
#include "engine/shade/walk_bake.h"
#include "engine/shade/walk_occlusion.h"
#include "engine/tour/tour.h"
#include "maps/maps.h"
#include "tests/draw/renderer_fixture.h"
#include "tests/support/support.h"

static void set_all_doors(Stage *s, float share) {
    for (int i = 0; i < s->building.opening_count; i++) s->doors[i] = share;
}

// Proves that in either look a culled frame is the unculled one to the last bit, doors half open.
Test(renderer, culling_changes_nothing, .timeout = 300) {
    static const char *const paths[] = {"build/maps/house.plan", "build/maps/office-plain.plan"};
    for (int k = 0; k < 2; k++) {
        Stage s;
        Error error;
        TourPath path;
        TourOptions options = tour_default_options();
        renderer_check_open_stage(&s, paths[k]);
        set_all_doors(&s, 0.4f);
        cr_assert(tour_make(&s.graph, "auto", &options, &s.arena, &path, &error), "%s", error.text);
        int frames = support_count(12, 200);
        for (int i = 0; i < frames; i++) {
            const TourFrame *at = &path.frames[(long)i * path.frame_count / frames];
            Camera camera = camera_look(at->eye, at->yaw, at->pitch, at->fov, WIDTH, HEIGHT);
            for (int look = 0; look < WALK_LOOKS; look++) {
                const uint8_t *culled = renderer_check_picture(&s, &camera, CULL_STAB, (WalkLook)look);
                const uint8_t *whole = renderer_check_picture(&s, &camera, CULL_NONE, (WalkLook)look);
                int pixels = renderer_check_differing(culled, whole, WIDTH * HEIGHT);
                cr_assert_eq(pixels, 0, "%s, frame %d, %s: %d pixels differ", paths[k], i,
                             WALK_LOOK_NAMES[look], pixels);
            }
        }
        renderer_check_close_stage(&s);
    }
}

// Proves that the two looks are of one scene: the same light to the eye. Tolerance: a twelfth of the range in the mean,
// since ambient occlusion is found in other ways; a lamp too many or too few in the eye's room is a fifth.
Test(renderer, looks_are_alike, .timeout = 120) {
    Stage s;
    renderer_check_open_stage(&s, "build/maps/house.plan");
    for (int i = 0; i < s.building.viewpoint_count; i++) {
        const Viewpoint *v = &s.building.viewpoints[i];
        Camera camera = camera_look(v->eye, v->yaw, v->pitch, v->fov, WIDTH, HEIGHT);
        const uint8_t *fast = renderer_check_picture(&s, &camera, CULL_STAB, WALK_FAST),
                      *fine = renderer_check_picture(&s, &camera, CULL_STAB, WALK_FINE);
        double sum = 0;
        for (int k = 0; k < WIDTH * HEIGHT * 3; k++) sum += fabs((double)fast[k] - fine[k]);
        sum /= WIDTH * HEIGHT * 3;
        cr_assert_gt(renderer_check_differing(fast, fine, WIDTH * HEIGHT), WIDTH * HEIGHT / 2,
                     "view %s: one look twice", v->name);
        cr_assert_lt(sum, 255.0 / 12, "view %s: the looks differ by %.1f in the mean", v->name, sum);
    }
    renderer_check_close_stage(&s);
}

// Proves that the surfaces of cells are seen from inside their cells only: an eye in the slab over a room looks into it, as
// if it had no ceiling and there were nothing else that faces down.
Test(renderer, surfaces_have_one_side, .timeout = 120) {
    Stage s;
    Error error;
    renderer_check_open_stage(&s, "build/maps/two-rooms.plan");
    const CellGraph *g = &s.graph;
    Vec3 above = s.building.start;
    above.z = s.building.storeys[0].floor + s.building.storeys[0].height + 0.15;
    Camera camera = camera_look(above, 0, -1.5, 1.2, WIDTH, HEIGHT);
    int *list = ARENA_ARRAY(&s.arena, int, g->object_count), count = 0;
    for (int o = 0; o < g->object_count; o++) {
        const Polygon *p = &g->polygons[g->objects[o].first_polygon];
        Plane plane = plane_of_polygon(g->vertices + p->first_vertex, p->vertex_count);
        if (vis_shown(&g->objects[o], s.doors) && (g->objects[o].kind != OBJECT_SURFACE || plane.n.z > -0.5))
            list[count++] = o;
    }
    cr_assert_lt(count, g->object_count - 4);
    for (int look = 0; look < WALK_LOOKS; look++) {
        const uint8_t *whole = renderer_check_picture(&s, &camera, CULL_NONE, (WalkLook)look);
        uint8_t rgb[WIDTH * HEIGHT * 3];
        cr_assert(walk_renderer_draw(s.renderer, &camera, list, count, (WalkLook)look, &error), "%s",
                  error.text);
        cr_assert(walk_renderer_finish_scene(s.renderer, &error) &&
                  walk_renderer_read(s.renderer, rgb, &error));
        cr_assert_eq(renderer_check_differing(whole, rgb, WIDTH * HEIGHT), 0,
                     "%s: ceilings are seen from above", WALK_LOOK_NAMES[look]);
    }
    renderer_check_close_stage(&s);
}

// Proves that a size from one pixel up is drawn, in either look, and that one after the other leaves nothing behind.
Test(renderer, any_size, .timeout = 120) {
    static const int sizes[][2] = {{1, 1},   {WIDTH, HEIGHT}, {3, 200}, {201, 1},
                                   {37, 21}, {WIDTH, HEIGHT}, {1, 1}};
    Stage s;
    Error error = {""};
    renderer_check_open_stage(&s, "build/maps/two-rooms.plan");
    for (int look = 0; look < WALK_LOOKS; look++) {
        const uint8_t *first = NULL;
        for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
            Camera camera = s.camera;
            camera.width = sizes[i][0];
            camera.height = sizes[i][1];
            const uint8_t *rgb = renderer_check_picture(&s, &camera, CULL_STAB, (WalkLook)look);
            walk_renderer_show(s.renderer, 0, 4, 4);
            if (camera.width != WIDTH) continue;
            if (first)
                cr_assert_eq(renderer_check_differing(first, rgb, WIDTH * HEIGHT), 0,
                             "another picture the second time");
            first = rgb;
        }
    }
    Camera camera = s.camera;
    camera.width = 1 << 20;
    cr_assert_not(walk_renderer_draw(s.renderer, &camera, NULL, 0, WALK_FAST, &error));
    cr_assert(strstr(error.text, "1048576 x 55 pixels (1 to "), "%s", error.text);
    renderer_check_close_stage(&s);
}

// Proves that leaves are drawn, and lit, where leaf_point has them: as a building in which they stand there for good.
// And that they come back: a state shown again is the same picture. Without light the baked look is the fast one.
Test(renderer, doors_move, .timeout = 120) {
    Stage s;
    Error error;
    renderer_check_open_stage(&s, "build/maps/house.plan");
    Camera camera = renderer_check_door(&s, WIDTH, HEIGHT);
    CellGraph still = s.graph;
    still.objects = ARENA_ARRAY(&s.arena, Object, still.object_count);
    still.vertices = ARENA_ARRAY(&s.arena, Vec3, still.vertex_count);
    memcpy(still.objects, s.graph.objects, (size_t)still.object_count * sizeof *still.objects);
    memcpy(still.vertices, s.graph.vertices, (size_t)still.vertex_count * sizeof *still.vertices);
    for (int o = 0; o < still.object_count; o++) still.objects[o].leaf = -1;
    static const float shares[] = {0, 0.01f, 0.35f, 1, 0.35f, 0};
    const uint8_t *seen[6];
    for (int i = 0; i < 6; i++) {
        set_all_doors(&s, shares[i]);
        seen[i] = renderer_check_picture(&s, &camera, CULL_NONE, WALK_FAST);
        const uint8_t *fine = renderer_check_picture(&s, &camera, CULL_NONE, WALK_FINE);
        vis_pose(&s.graph, s.doors, still.vertices);
        Stage other = s;
        other.renderer = walk_renderer_new(&still, &s.arena, &error);
        cr_assert(other.renderer, "%s", error.text);
        for (int look = 0; look < WALK_LOOKS; look++) {
            const uint8_t *there = renderer_check_picture(&other, &camera, CULL_NONE, (WalkLook)look);
            int pixels = renderer_check_differing(look == WALK_FINE ? fine : seen[i], there, WIDTH * HEIGHT);
            cr_assert_eq(pixels, 0, "open by %g, %s: %d pixels differ", (double)shares[i],
                         WALK_LOOK_NAMES[look], pixels);
        }
        walk_renderer_free(other.renderer);
    }
    cr_assert_eq(renderer_check_differing(seen[2], seen[4], WIDTH * HEIGHT), 0,
                 "half open is not the same again");
    cr_assert_eq(renderer_check_differing(seen[0], seen[5], WIDTH * HEIGHT), 0,
                 "closed is not the same again");
    cr_assert_gt(renderer_check_differing(seen[0], seen[3], WIDTH * HEIGHT), WIDTH * HEIGHT / 10,
                 "no door is seen to move");
    renderer_check_close_stage(&s);
}

// Proves that in the baked look, too, leaves are drawn where doors stand, though they are moved only when they are drawn: a door is seen
// to move, and a state shown again is the same picture.
Test(renderer, doors_move_in_baked_light, .timeout = 120) {
    static const float shares[] = {0, 0.35f, 1, 0.35f, 0};
    Stage s;
    Mesh mesh;
    RadSolution solution;
    Error error;
    MeshOptions options = mesh_default_options();
    const uint8_t *seen[5];
    options.element = 0.5;
    renderer_check_open_stage(&s, "build/maps/house.plan");
    Camera camera = renderer_check_door(&s, WIDTH, HEIGHT);
    cr_assert(mesh_build(&s.graph, NULL, &options, &s.arena, &mesh, &error), "%s", error.text);
    cr_assert(rad_start_dark(&mesh, &s.arena, &solution, &error), "%s", error.text);
    for (int e = 0; e < mesh.element_count; e++)
        for (int c = 0; c < 3; c++) solution.radiosity[e][c] = 0.05f + 0.01f * (float)(e * 7 % 60);
    float *baked = ARENA_ARRAY(&s.arena, float, s.building.opening_count + 1);
    WalkLight light = {.mesh = &mesh, .solution = &solution, .door_open = baked};
    cr_assert(walk_renderer_light(s.renderer, &light, &s.arena, &error), "%s", error.text);
    walk_renderer_tone(s.renderer, 1, FALSE_COLOUR_OFF);
    for (int i = 0; i < 5; i++) {
        set_all_doors(&s, shares[i]);
        seen[i] = renderer_check_picture(&s, &camera, CULL_NONE, WALK_BAKED);
    }
    cr_expect_gt(renderer_check_differing(seen[0], seen[2], WIDTH * HEIGHT), WIDTH * HEIGHT / 10);
    cr_expect_gt(renderer_check_differing(seen[0], seen[1], WIDTH * HEIGHT), WIDTH * HEIGHT / 20);
    cr_expect_eq(renderer_check_differing(seen[1], seen[3], WIDTH * HEIGHT), 0);
    cr_expect_eq(renderer_check_differing(seen[0], seen[4], WIDTH * HEIGHT), 0);
    renderer_check_close_stage(&s);
}

// Proves that the sky of a day is drawn as daylight_seen has it, pixel by pixel, the sun's disc where the sun stands and white, for a clear
// morning and an overcast noon. Tolerance: rounding to 8 bits, and floats in steep places.
Test(renderer, sky_of_a_day_by_direction, .timeout = 120) {
    static const double EXPOSURE = 0.02;
    for (int weather = 0; weather < DAYLIGHT_WEATHERS; weather++) {
        Stage s;
        Mesh mesh;
        RadSolution solution;
        Error error;
        MeshOptions options = mesh_default_options();
        SunPosition sun = {.altitude = 0.1, .azimuth = 0, .distance = 1};
        options.element = 1;
        renderer_check_open_stage(&s, "build/maps/two-rooms.plan");
        // Towards the sun.
        Camera camera = camera_look(s.camera.eye, M_PI / 2, 0, 1.2, WIDTH, HEIGHT);
        cr_assert(mesh_build(&s.graph, NULL, &options, &s.arena, &mesh, &error), "%s", error.text);
        cr_assert(rad_start_dark(&mesh, &s.arena, &solution, &error), "%s", error.text);
        solution.day = daylight_of(&sun, 0, weather);
        WalkLight light = {.mesh = &mesh, .solution = &solution};
        cr_assert(walk_renderer_light(s.renderer, &light, &s.arena, &error), "%s", error.text);
        walk_renderer_tone(s.renderer, EXPOSURE, FALSE_COLOUR_OFF);
        uint8_t *rgb = arena_alloc(&s.arena, WIDTH * HEIGHT, 3);
        cr_assert(walk_renderer_draw(s.renderer, &camera, NULL, 0, WALK_BAKED, &error), "%s", error.text);
        cr_assert(walk_renderer_finish_scene(s.renderer, &error), "%s", error.text);
        cr_assert(walk_renderer_read(s.renderer, rgb, &error), "%s", error.text);
        int discs = 0;
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            Vec3 w = vec3_normalize(camera_ray(&camera, i % WIDTH + 0.5, i / WIDTH + 0.5));
            double seen[3], away = acos(fmin(vec3_dot(w, solution.day.sun), 1)) / DAYLIGHT_SUN_RADIUS;
            bool edge = away > 0.8 && away < 1.2;
            daylight_seen(&solution.day, w, seen);
            discs += away < 0.8 && solution.day.beam[0] > 0 && rgb[3 * i] >= 250;
            for (int c = 0; c < 3 && !edge && fabs(w.z) > 0.002; c++)
                cr_expect_float_eq(rgb[3 * i + c], 255 * exposure_on_screen(seen[c] * EXPOSURE), 2,
                                   "pixel %d of weather %d", i, weather);
        }
        cr_expect_eq(discs > 0, solution.day.beam[0] > 0);
        renderer_check_close_stage(&s);
    }
}

// Proves that the sky of baked light is as bright on the screen as the light that it sends, and the ground as daylight_seen_ground has it;
// and that the sky of lamps alone is dark. A sky of radiance L has the radiosity pi L. Tolerance: rounding to 8 bits.
Test(renderer, baked_sky_is_as_bright_as_its_light, .timeout = 120) {
    static const double RADIANCE[2][3] = {{0, 0, 0}, {0.1, 0.2, 0.4}};
    static const double EXPOSURE = 0.5;
    for (int day = 0; day < 2; day++) {
        Stage s;
        Mesh mesh;
        RadSolution solution;
        Error error;
        MeshOptions options = mesh_default_options();
        options.element = 1;
        renderer_check_open_stage(&s, "build/maps/two-rooms.plan");
        cr_assert(mesh_build(&s.graph, NULL, &options, &s.arena, &mesh, &error), "%s", error.text);
        cr_assert(rad_start_dark(&mesh, &s.arena, &solution, &error), "%s", error.text);
        solution.day = daylight_uniform(RADIANCE[day]);
        WalkLight light = {.mesh = &mesh, .solution = &solution};
        cr_assert(walk_renderer_light(s.renderer, &light, &s.arena, &error), "%s", error.text);
        walk_renderer_tone(s.renderer, EXPOSURE, FALSE_COLOUR_OFF);
        uint8_t *rgb = arena_alloc(&s.arena, WIDTH * HEIGHT, 3);
        cr_assert(walk_renderer_draw(s.renderer, &s.camera, NULL, 0, WALK_BAKED, &error), "%s", error.text);
        cr_assert(walk_renderer_finish_scene(s.renderer, &error), "%s", error.text);
        cr_assert(walk_renderer_read(s.renderer, rgb, &error), "%s", error.text);
        const uint8_t *above = rgb, *ground = rgb + 3 * (WIDTH * HEIGHT - 1);
        for (int c = 0; c < 3; c++) {
            double light_above = M_PI * RADIANCE[day][c] * EXPOSURE, below[3];
            daylight_seen_ground(&solution.day, below);
            if (day) {
                cr_expect_float_eq(above[c], 255 * exposure_on_screen(light_above), 1);
                cr_expect_float_eq(ground[c], 255 * exposure_on_screen(below[c] * EXPOSURE), 1);
            } else {
                cr_expect(above[c] < 64 && ground[c] < 16, "night: %d over %d", above[c], ground[c]);
            }
        }
        renderer_check_close_stage(&s);
    }
}
