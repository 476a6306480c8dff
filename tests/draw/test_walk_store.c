// test_walk_store.c - a building that is held in part looks like one that is held whole.
#include <criterion/criterion.h>
#include <stdlib.h>

#include "engine/core/random.h"
#include "engine/draw/view.h"
#include "tests/draw/renderer_fixture.h"

static void look_anywhere(Stage *s, Random *random, Camera *out) {
    int cell = random_index(random, s->graph.cell_count);
    Box box = s->graph.cells[cell].box;
    Vec3 share = vec3(random_unit(random), random_unit(random), random_unit(random));
    Vec3 eye =
        vec3(box.min.x + share.x * (box.max.x - box.min.x), box.min.y + share.y * (box.max.y - box.min.y),
             box.min.z + share.z * (box.max.z - box.min.z));
    *out = camera_look(eye, 2 * M_PI * random_unit(random), random_unit(random) - 0.5, 1.2, WIDTH, HEIGHT);
}

// Pixels of which a channel differs by more than so many steps of the screen.
static int differing(const uint8_t *a, const uint8_t *b, int steps) {
    int count = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        int most = 0;
        for (int c = 0; c < 3; c++)
            most = abs(a[3 * i + c] - b[3 * i + c]) > most ? abs(a[3 * i + c] - b[3 * i + c]) : most;
        count += most > steps;
    }
    return count;
}

// Draws the same views, with doors that move and what is seen in mirrors, from both; objects ahead are made only where asked for. Returns
// how many mirrors were in view.
static int compare(const char *file, bool ahead, int views) {
    Stage s;
    int in_view = 0;
    Error error;
    Random random = {7};
    renderer_check_open_stage(&s, file);
    WalkRenderer *whole = s.renderer;
    // So small that the halves are filled and emptied over and over.
    WalkStoreLimits tight = {0, (int)walk_renderer_held(whole).vertices / 5, 80};
    WalkRenderer *part = walk_renderer_new_limited(&s.graph, &tight, &s.arena, &error);
    Mirrors *mirrors = mirrors_new(&s.graph, &s.forest, &s.arena);
    cr_assert(part, "%s", error.text);
    cr_assert_eq(walk_renderer_held(part).vertices, 0, "something is held before anything was drawn");
    for (int i = 0; i < views; i++) {
        Camera camera;
        look_anywhere(&s, &random, &camera);
        for (int k = 0; k < s.building.opening_count; k++)
            if (random_unit(&random) < 0.2) s.doors[k] = (float)random_unit(&random);
        WalkLook look = (WalkLook)(i % 2);
        Eye eye = walk_eye(&camera);
        VisResult seen = vis_query(s.query, &eye, vis_locate(&s.graph, camera.eye, -1), s.doors, CULL_STAB);
        const MirrorView *shown;
        int count = mirrors_look(mirrors, &camera, &seen, s.doors, CULL_STAB, &shown);
        walk_renderer_mirrors(whole, shown, count);
        walk_renderer_mirrors(part, shown, count);
        in_view += count;
        s.renderer = whole;
        const uint8_t *expected = renderer_check_picture(&s, &camera, CULL_STAB, look);
        s.renderer = part;
        const uint8_t *picture = renderer_check_picture(&s, &camera, CULL_STAB, look);
        if (ahead) walk_renderer_ahead(part, &s.forest, vis_locate(&s.graph, camera.eye, -1));
        // Texels lie elsewhere in the texture. OpenGL takes their places by 256ths of a texel, and neighbours in a corner may differ by
        // all brightness: a step of the screen each way, which the picture of a bright texture doubles. By a step an edge may also be
        // just smoothed in one picture and just not in the other: a few pixels.
        int steps = look == WALK_FAST ? 4 : 0, excused = look == WALK_FAST ? 5 : 0;
        cr_assert_leq(differing(expected, picture, steps), excused, "%s: %d pixels of view %d differ", file,
                      differing(expected, picture, steps), i);
    }
    long emptied = walk_renderer_held(part).emptied;
    cr_assert_gt(emptied, 0, "%s: no half was emptied", file);
    walk_renderer_free(part);
    mirrors_free(mirrors);
    s.renderer = whole;
    renderer_check_close_stage(&s);
    return in_view;
}

// Proves that what comes and goes leaves no trace: views of random places with doors that move are those of a renderer that
// holds everything, whether objects are made ahead or when they are drawn. One of the homes has pictures, one building mirrors.
Test(walk_store, parts_look_like_the_whole, .timeout = 120) {
    for (int ahead = 0; ahead < 2; ahead++) {
        compare("build/maps/house.plan", ahead, 60);
        compare("build/maps/hillside.sh3d", ahead, 20);
        cr_assert_gt(compare("maps/buildings/mirrors.plan", ahead, 60), 20);
    }
}

// Proves that a frame that needs more than there is room for gets it: the halves grow, and the picture is right.
Test(walk_store, grows_where_one_frame_needs_it, .timeout = 120) {
    Stage s;
    Error error;
    WalkStoreLimits tiny = {0, 40, 4};
    renderer_check_open_stage(&s, "build/maps/office-plain.plan");
    WalkRenderer *whole = s.renderer, *part = walk_renderer_new_limited(&s.graph, &tiny, &s.arena, &error);
    cr_assert(part, "%s", error.text);
    const uint8_t *expected = renderer_check_picture(&s, &s.camera, CULL_NONE, WALK_FINE);
    s.renderer = part;
    const uint8_t *picture = renderer_check_picture(&s, &s.camera, CULL_NONE, WALK_FINE);
    cr_assert_eq(renderer_check_differing(expected, picture, WIDTH * HEIGHT), 0);
    cr_assert_gt(walk_renderer_held(part).grown, 3);
    cr_assert_eq(walk_renderer_held(part).vertices, walk_renderer_held(whole).vertices);
    walk_renderer_free(part);
    s.renderer = whole;
    renderer_check_close_stage(&s);
}

// Proves that what was made ahead is there: after enough frames in one place everything that may be seen from its cell is held, so
// that a look around makes nothing.
Test(walk_store, a_look_around_finds_it_there, .timeout = 120) {
    Stage s;
    Error error;
    WalkStoreLimits limits = {0, 1 << 16, 512};
    renderer_check_open_stage(&s, "build/maps/office-plain.plan");
    WalkRenderer *whole = s.renderer, *part = walk_renderer_new_limited(&s.graph, &limits, &s.arena, &error);
    cr_assert(part, "%s", error.text);
    s.renderer = part;
    int cell = vis_locate(&s.graph, s.camera.eye, -1);
    renderer_check_picture(&s, &s.camera, CULL_STAB, WALK_FAST);
    for (int i = 0; i < 200; i++) walk_renderer_ahead(part, &s.forest, cell);
    long made = walk_renderer_held(part).vertices;
    for (int i = 0; i < 16; i++) {
        Camera camera = camera_look(s.camera.eye, i * M_PI / 8, 0, 1.2, WIDTH, HEIGHT);
        renderer_check_picture(&s, &camera, CULL_STAB, WALK_FAST);
    }
    cr_assert_eq(walk_renderer_held(part).vertices, made, "a look around made %ld vertices",
                 walk_renderer_held(part).vertices - made);
    walk_renderer_free(part);
    s.renderer = whole;
    renderer_check_close_stage(&s);
}
